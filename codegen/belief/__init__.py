# SPDX-License-Identifier: Apache-2.0
"""The functions of the filters: hypotheses, evidence, exact posteriors, redraws.

Takes the model's factors. Gives ``template_data.Function`` values.
"""
