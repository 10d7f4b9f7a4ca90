# SPDX-License-Identifier: Apache-2.0
"""Values that are known when the model is compiled: consts, params, tables, settings.

Takes constant expressions and the settings of an instance. Gives values and tables.
"""
