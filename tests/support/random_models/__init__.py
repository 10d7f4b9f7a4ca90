# SPDX-License-Identifier: Apache-2.0
"""Random model files, made smaller where they fail, and many of them compared in one C++ program.

In order of dependency: ``tree`` (a text as a tree, and its shrinking), ``sorts`` (types), ``expressions``,
``laws`` and ``draws`` (what may follow ``~``), ``generator`` (whole models), ``batches`` (C++ against the
interpreter) and ``failures`` (what fails of many seeds).
"""
