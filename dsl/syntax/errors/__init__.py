# SPDX-License-Identifier: Apache-2.0
"""Syntax errors in the author's words: a rule recognises each common mistake.

Takes the parser's failure and the text around it. Gives one ``Diagnostic`` with a remedy.
"""
