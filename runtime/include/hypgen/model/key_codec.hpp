// SPDX-License-Identifier: Apache-2.0
// Observation keys from values and back, for a model that is known by its fields alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/core/span.hpp"
#include "hypgen/model/embedded_model.hpp"
#include "hypgen/model/key.hpp"

namespace hypgen {

// The caller sees one order of values, that of the fields, for keys of one word and of several.
class KeyCodec {
 public:
  KeyCodec(const std::vector<ValueField>& fields, std::size_t words);

  std::size_t words() const { return words_; }
  std::size_t values() const { return digits_.size(); }
  const std::vector<KeyDigit>& digits() const { return digits_; }

  // The key of values that `check_values` accepts.
  void encode(Span<const std::int32_t> values, std::vector<std::uint64_t>& key) const;

  // The values of a key; false if the model has no such key.
  bool decode(KeyWords key, std::vector<std::int32_t>& values) const;

  // The same into a place for so many values.
  bool decode(KeyWords key, std::int32_t* values) const;

 private:
  std::vector<KeyDigit> digits_;
  std::size_t words_;
};

}  // namespace hypgen
