"""Text to a checked, typed intermediate representation of a POMDP; knows nothing of C++.

Pipeline: ``parser`` (text -> ``ast``) -> ``lower`` with ``typecheck`` (``ast`` -> ``ir``) -> ``analysis``
(stages, observation key, filter rules). ``interpreter`` gives the IR its meaning. User mistakes are
``Diagnostic`` values; any other exception is a bug of hypgen.
"""
