# SPDX-License-Identifier: Apache-2.0
"""The functions that the runtime calls for a model: steps, rewards, policy, memory, descriptor.

Takes the model after ``passes``. Gives ``template_data.Function`` values.
"""
