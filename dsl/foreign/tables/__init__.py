"""What the readers of other formats give and the writer takes: variables, and tables of numbers.

Takes rows and names of a foreign file. Gives a ``ForeignModel``; ``trouble`` gathers mistakes.
"""
