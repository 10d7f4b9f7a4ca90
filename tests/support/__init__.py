# SPDX-License-Identifier: Apache-2.0
"""What several tests share: measurements of the structure, models built by hand, and small programs."""
