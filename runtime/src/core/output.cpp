// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/output.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>

namespace hypgen {

namespace {

constexpr std::size_t kWaiting = std::size_t{1} << 16;
constexpr mode_t kNewFile = 0666;  // less what the umask takes

bool is_regular(int fd) {
  struct stat found{};
  return fstat(fd, &found) == 0 && S_ISREG(found.st_mode);
}

// Gives 0 or the system's error. Pipes and some devices cannot be synced.
int sync(int fd) { return !is_regular(fd) || fsync(fd) == 0 ? 0 : errno; }

void sync_folder(const std::string& folder) {
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  fsync(fd);  // without it the file is whole, but may be the old one after a crash of the machine
  ::close(fd);
}

// The file that a path leads to, through links.
std::string resolved(const std::string& file) {
  char* const found = realpath(file.c_str(), nullptr);
  if (found == nullptr) return file;
  std::string path = found;
  std::free(found);
  return path;
}

// The folder of a path, with the slash at its end; empty for the current one.
std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

}  // namespace

Output::Output(const std::string& file, Kind kind) : file_(file), kind_(kind) {
  struct stat found{};
  const bool exists = stat(file.c_str(), &found) == 0;
  if (file == "-") {
    fd_ = STDOUT_FILENO;
  } else if (kind == Kind::kWhole && (!exists || S_ISREG(found.st_mode))) {
    target_ = resolved(file);
    open_beside();
    if (exists && fd_ >= 0) fchmod(fd_, found.st_mode & 07777);
  } else {
    fd_ = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kNewFile);
  }
  if (fd_ < 0) fail(errno);
}

Output::~Output() {
  if (fd_ >= 0 && fd_ != STDOUT_FILENO) ::close(fd_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

void Output::open_beside() {
  const std::string folder = folder_of(target_);
  const std::string name = folder + "." + target_.substr(folder.size()) + "." + std::to_string(getpid());
  // A process of this number that was killed may have left one.
  for (int i = 0; i < 100 && fd_ < 0; ++i) {
    temporary_ = name + "." + std::to_string(i);
    fd_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kNewFile);
    if (fd_ < 0 && errno != EEXIST) break;
  }
  if (fd_ < 0) temporary_.clear();
}

bool Output::write(const std::string& text) {
  if (!ok()) return false;
  if (kind_ == Kind::kLines) return put(text.data(), text.size());
  waiting_ += text;
  if (waiting_.size() < kWaiting) return true;
  const bool written = put(waiting_.data(), waiting_.size());
  waiting_.clear();
  return written;
}

bool Output::close() {
  if (!ok() || fd_ < 0) return ok();
  if (!put(waiting_.data(), waiting_.size())) return false;
  waiting_.clear();
  if (const int error = sync(fd_)) return fail(error);
  if (fd_ == STDOUT_FILENO) return true;
  const bool closed = ::close(fd_) == 0;
  fd_ = -1;
  if (!closed) return fail(errno);
  if (temporary_.empty()) return true;
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) return fail(errno);
  temporary_.clear();
  const std::string folder = folder_of(target_);
  sync_folder(folder.empty() ? "." : folder);
  return true;
}

bool Output::reader_is_gone() const { return fd_ == STDOUT_FILENO && error_ == EPIPE; }

std::string Output::problem() const {
  return (file_ == "-" ? std::string("standard output") : file_) +
         ": cannot be written: " + std::generic_category().message(error_);
}

bool Output::put(const char* data, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t written = ::write(fd_, data + done, size - done);
    if (written > 0) {
      done += static_cast<std::size_t>(written);
    } else if (written < 0 && errno == EAGAIN) {  // a pipe whose reader has made it so
      pollfd room{fd_, POLLOUT, 0};
      poll(&room, 1, -1);
    } else if (written == 0 || errno != EINTR) {
      const int error = written == 0 ? ENOSPC : errno;
      take_back(done);
      return fail(error);
    }
  }
  return true;
}

// Removes what a file has just got, unless somebody else has written since.
void Output::take_back(std::size_t size) const {
  if (size == 0 || !is_regular(fd_)) return;
  const off_t end = lseek(fd_, 0, SEEK_CUR);
  struct stat found{};
  if (fstat(fd_, &found) != 0 || end != found.st_size) return;
  const off_t before = end - static_cast<off_t>(size);
  if (ftruncate(fd_, before) == 0) lseek(fd_, before, SEEK_SET);
}

bool Output::fail(int error) {
  error_ = error;
  return false;
}

}  // namespace hypgen
