"""hypgen compiles declarative POMDP models into native online planners."""

__version__ = "0.1.0"
