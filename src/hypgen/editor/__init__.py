# SPDX-License-Identifier: Apache-2.0
"""What editors ask about models: words and colours, and a language server over the compiler's front end."""
