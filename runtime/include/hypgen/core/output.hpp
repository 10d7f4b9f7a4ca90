// SPDX-License-Identifier: Apache-2.0
// Where results go: standard output or a file. What does not fit is known at once, with the system's reason.
#pragma once

#include <cstddef>
#include <string>

namespace hypgen {

class Output {
 public:
  // Lines go out as they come. A whole file takes its place at `close`: a program that dies before leaves what
  // was there.
  enum class Kind { kLines, kWhole };

  // `file` is a path, or "-" for standard output. What is there and is no regular file (a pipe, a device) is
  // written to as it is.
  Output(const std::string& file, Kind kind);
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  // False from the first text on that does not fit. Of that text a regular file keeps nothing.
  bool write(const std::string& text);

  // Syncs what was written, so that it outlives a crash of the machine, and puts a whole file into its place.
  bool close();

  bool ok() const { return error_ == 0; }
  // Whether standard output is a pipe that nobody reads any more.
  bool reader_is_gone() const;
  // Which file cannot be written, and why.
  std::string problem() const;

 private:
  void open_beside();
  bool put(const char* data, std::size_t size);
  void take_back(std::size_t size) const;
  bool fail(int error);

  std::string file_;
  Kind kind_;
  int fd_ = -1;
  int error_ = 0;          // of the system; 0: none
  std::string target_;     // whose place `temporary_` is to take; empty: written in place
  std::string temporary_;  // beside it
  std::string waiting_;    // of a whole file, not yet written
};

}  // namespace hypgen
