// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace rcl_interfaces::msg {

struct ParameterDescriptor {
  std::string description;
  bool dynamic_typing = false;
};

}  // namespace rcl_interfaces::msg
