"""Text that commands print: explanations, episodes, comparisons, findings, the error index.

Takes data of the other packages. Gives text.
"""
