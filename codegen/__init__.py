# SPDX-License-Identifier: Apache-2.0
"""IR to ``{path: text}`` of a C++ project: pure, deterministic, and the only user of Jinja2.

Takes an ``ir.Model``. Gives files (``generate.generate``) or facts about them (``model_report``).
"""
