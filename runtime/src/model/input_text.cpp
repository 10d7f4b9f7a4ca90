// SPDX-License-Identifier: Apache-2.0
#include "input_text.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

namespace hypgen {

namespace {

using Json = nlohmann::json;

// Any array of a model has fewer dimensions, and what walks over values calls itself once for each.
constexpr int kMostDepth = 100;

// How long a named pipe may have no writer at first.
constexpr int kPipeMilliseconds = 1000;

constexpr std::size_t kMostProblem = 240;  // characters of what the parser says

struct Refusal {
  std::string why;
};

// A file that closes itself.
class InputFile {
 public:
  // Without the flag, opening a named pipe would wait for a writer for ever. Reading then ends at once where
  // there is none, and waits where there is one.
  explicit InputFile(const std::string& file)
      : descriptor_(open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
    if (descriptor_ < 0) return;
    struct stat facts{};
    pollfd waiting{descriptor_, POLLIN, 0};
    if (fstat(descriptor_, &facts) != 0) return;
    if (S_ISFIFO(facts.st_mode)) poll(&waiting, 1, kPipeMilliseconds);
    fcntl(descriptor_, F_SETFL, fcntl(descriptor_, F_GETFL) & ~O_NONBLOCK);
  }
  ~InputFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }

  // The next bytes: 0 at the end, -1 and errno where they cannot be read.
  ssize_t read_some(std::vector<char>& block) const {
    ssize_t found = -1;
    do {
      found = read(descriptor_, block.data(), block.size());
    } while (found < 0 && errno == EINTR);
    return found;
  }

 private:
  int descriptor_;
};

std::string cannot_be_read() { return "cannot be read: " + std::generic_category().message(errno); }

// The bytes of the character of UTF-8 at `at`, 0 if there is none.
std::size_t length_of_character(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return static_cast<unsigned char>(i < text.size() ? text[i] : '\0');
  };
  const unsigned char first = byte(at);
  const std::size_t length = first < 0x80 ? 1 : first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (first > 0xF4) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0U) != 0x80U) return 0;
  }
  // The second byte tells forms that are too long, halves of pairs, and what is beyond the last character.
  const unsigned char second = byte(at + 1);
  const bool is_wrong = (first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ||
                        (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F);
  return is_wrong ? 0 : length;
}

// Refuses what is too deep and names that stand twice, while the parser reads.
class Watch {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    switch (event) {
      case Json::parse_event_t::object_start:
        refuse_depth(depth);
        names_.emplace_back();
        break;
      case Json::parse_event_t::array_start:
        refuse_depth(depth);
        break;
      case Json::parse_event_t::object_end:
        names_.pop_back();
        break;
      case Json::parse_event_t::key: {
        const auto& name = parsed.get_ref<const std::string&>();
        if (!names_.back().insert(name).second)
          throw Refusal{'"' + excerpt(name) + "\" is given twice in one object"};
        break;
      }
      case Json::parse_event_t::array_end:
      case Json::parse_event_t::value:
        break;
    }
    return true;
  }

 private:
  static void refuse_depth(int depth) {
    if (depth >= kMostDepth)
      throw Refusal{"has values nested deeper than " + std::to_string(kMostDepth) + " levels"};
  }

  std::vector<std::set<std::string>> names_;  // of the objects that are open
};

}  // namespace

std::string excerpt(const std::string& text, std::size_t most) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = length_of_character(text, at);
    if (shown.size() + std::max<std::size_t>(length, 1) > most) return shown + "...";
    const bool is_control = length == 1 && (static_cast<unsigned char>(text[at]) < 0x20 || text[at] == 0x7F);
    const bool is_late_control =
        length == 2 && text[at] == '\xC2' && static_cast<unsigned char>(text[at + 1]) < 0xA0;
    if (length == 0) {
      shown += '?';
    } else if (is_control || is_late_control) {
      shown += ' ';  // a terminal would obey it
    } else {
      shown.append(text, at, length);
    }
    at += std::max<std::size_t>(length, 1);
  }
  return shown;
}

bool read_input_file(const std::string& file, std::size_t most, std::string& text, std::string& error) {
  const auto refuse = [&error](std::string why) {
    error = std::move(why);
    return false;
  };
  const InputFile input(file);
  if (!input.is_open()) return refuse(cannot_be_read());
  text.clear();
  std::vector<char> block(std::size_t{1} << 16);
  while (true) {
    const ssize_t count = input.read_some(block);
    if (count < 0) return refuse(cannot_be_read());
    if (count == 0) return true;
    const auto end = block.begin() + count;
    if (std::find(block.begin(), end, '\0') != end) return refuse("is a binary file, not a text");
    text.append(block.begin(), end);
    if (text.size() > most) return refuse("is larger than " + megabytes(most));
  }
}

bool parse_json(const std::string& text, Json& json, std::string& error) {
  Watch watch;
  try {
    json = Json::parse(text, [&watch](int depth, Json::parse_event_t event, const Json& parsed) {
      return watch(depth, event, parsed);
    });
    return true;
  } catch (const Refusal& refusal) {
    error = refusal.why;
  } catch (const Json::exception& problem) {
    const std::string message = problem.what();  // "[json.exception.parse_error.101] parse error at ..."
    error = "not valid JSON: " + excerpt(message.substr(message.find("] ") + 2), kMostProblem);
  }
  return false;
}

}  // namespace hypgen
