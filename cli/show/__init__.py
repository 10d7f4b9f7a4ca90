# SPDX-License-Identifier: Apache-2.0
"""Text that commands print: explanations, episodes, comparisons, findings, the error index.

Takes data of the other packages. Gives text.
"""
