// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/key_codec.hpp"

#include "hypgen/math/float_bits.hpp"

namespace hypgen {

KeyCodec::KeyCodec(const std::vector<ValueField>& fields, std::size_t words) : words_(words) {
  for (const ValueField& field : fields) {
    const bool is_float = field.kind == ValueKind::kFloat;
    const auto low = is_float ? 0 : static_cast<std::int64_t>(field.low);
    const std::uint64_t size =
        is_float ? std::uint64_t{1} << 32
                 : static_cast<std::uint64_t>(static_cast<std::int64_t>(field.high) - low) + 1;
    digits_.insert(digits_.end(), field.length(), KeyDigit{size, low, is_float});
  }
}

void KeyCodec::encode(Span<const std::int32_t> values, std::vector<std::uint64_t>& key) const {
  key.assign(words_, 0);
  KeyCursor cursor;
  for (std::size_t i = 0; i < digits_.size(); ++i) {
    const KeyDigit& digit = digits_[i];
    const std::uint64_t number = digit.is_float ? static_cast<std::uint32_t>(values[i])
                                                : static_cast<std::uint64_t>(values[i] - digit.low);
    if (words_ == 1) {  // the first digit is the most significant, as in generated code
      key[0] = key[0] * digit.size + number;
    } else {
      cursor.advance(digit.size);
      key[cursor.word()] += number * cursor.place();
    }
  }
}

bool KeyCodec::decode(KeyWords key, std::vector<std::int32_t>& values) const {
  values.resize(digits_.size());
  return decode(key, values.data());
}

bool KeyCodec::decode(KeyWords key, std::int32_t* values) const {
  return key.size() == words_ && decode_key(digits_.data(), digits_.size(), key, values);
}

}  // namespace hypgen
