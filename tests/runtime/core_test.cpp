// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "hypgen/core/interrupt.hpp"
#include "hypgen/core/output.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/core/progress.hpp"
#include "hypgen/core/status.hpp"

namespace hypgen {
namespace {

// What a child process comes to in which `body` runs: its exit code, or 128 and the signal that ended it.
int ended(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    for (const int one : {SIGINT, SIGTERM, SIGHUP}) std::signal(one, SIG_DFL);
    _exit(body());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(Interrupt, TheFirstIsNotedAndALaterOneEndsTheProgram) {
  for (const int first : {SIGINT, SIGTERM, SIGHUP}) {
    const auto body = [&](bool twice, bool later) {
      return ended([=] {
        catch_interrupts();
        if (interrupted()) return 1;
        std::raise(first);
        if (later) usleep(150'000);
        if (twice) std::raise(SIGTERM);
        return interrupted() ? interrupt_code() : 2;
      });
    };
    EXPECT_EQ(body(false, false), 128 + first);
    EXPECT_EQ(body(true, false), 128 + first) << "`timeout` sends its signal twice";
    EXPECT_EQ(body(true, true), 128 + SIGTERM);
  }
}

TEST(Interrupt, WhatIsIgnoredAtTheStartStaysSo) {
  EXPECT_EQ(ended([] {
              std::signal(SIGHUP, SIG_IGN);
              catch_interrupts();
              std::raise(SIGHUP);
              return interrupted() ? 1 : 0;
            }),
            0);
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Output, SaysAtTheLineThatDidNotFitWhyItDidNot) {
  Output full("/dev/full", Output::Kind::kLines);
  EXPECT_TRUE(full.ok());
  EXPECT_FALSE(full.write("line\n"));
  EXPECT_EQ(full.problem(), "/dev/full: cannot be written: No space left on device");
  Output whole("/dev/full", Output::Kind::kWhole);
  EXPECT_TRUE(whole.write("few"));
  EXPECT_FALSE(whole.close());
  const Output nowhere("/nonexistent/file", Output::Kind::kWhole);
  EXPECT_EQ(nowhere.problem(), "/nonexistent/file: cannot be written: No such file or directory");
}

TEST(Output, KeepsNothingOfALineThatDidNotFit) {
  const std::string file = ::testing::TempDir() + "limited.txt";
  const int code = ended([&] {
    let_writes_fail();
    const rlimit limit{10, 10};
    setrlimit(RLIMIT_FSIZE, &limit);
    Output out(file, Output::Kind::kLines);
    return out.write("12345\n") && !out.write("67890\n") && !out.write("7\n") ? 0 : 1;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(text_of(file), "12345\n");
}

TEST(Output, AWholeFileTakesItsPlaceAtTheEnd) {
  const std::string folder = ::testing::TempDir() + "whole/", file = folder + "file", link = folder + "link";
  mkdir(folder.c_str(), 0700);
  std::ofstream(file) << "old";
  chmod(file.c_str(), 0640);
  unlink(link.c_str());
  ASSERT_EQ(symlink("file", link.c_str()), 0);
  {
    Output out(link, Output::Kind::kWhole);
    out.write("new");
    EXPECT_EQ(text_of(file), "old");
  }
  EXPECT_EQ(text_of(file), "old") << "it was not closed";
  Output out(link, Output::Kind::kWhole);
  EXPECT_TRUE(out.write(std::string(100'000, 'x')) && out.write("new") && out.close());
  EXPECT_EQ(text_of(link), std::string(100'000, 'x') + "new");
  struct stat found{};
  ASSERT_EQ(lstat(link.c_str(), &found), 0);
  EXPECT_TRUE(S_ISLNK(found.st_mode));
  ASSERT_EQ(stat(file.c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0640U);
  EXPECT_EQ(rmdir(folder.c_str()), -1);
  unlink(link.c_str());
  unlink(file.c_str());
  EXPECT_EQ(rmdir(folder.c_str()), 0) << "a temporary file was left";
}

TEST(Output, AReaderThatHasGoneIsNoFailure) {
  const int code = ended([] {
    let_writes_fail();
    int ends[2];
    if (pipe(ends) != 0) return 1;
    close(ends[0]);
    dup2(ends[1], STDOUT_FILENO);
    return print("Tiger", "nobody reads this\n");
  });
  EXPECT_EQ(code, kReaderIsGone);
}

// What two episodes show on standard error, if that is a terminal.
std::string shown(bool wanted) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  EXPECT_TRUE(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
  const int theirs = open(ptsname(terminal), O_RDWR | O_NOCTTY), before = dup(STDERR_FILENO);
  dup2(theirs, STDERR_FILENO);
  {
    Progress progress(2, 90, wanted);
    progress.update(1, 4, -2.5);
  }
  dup2(before, STDERR_FILENO);
  for (const int file : {theirs, before}) close(file);
  std::string all;
  char text[1000];  // the system hands on a part at a time, and an error once nobody has the terminal
  for (ssize_t size; (size = read(terminal, text, sizeof text)) > 0;) {
    all.append(text, static_cast<std::size_t>(size));
  }
  close(terminal);
  return all;
}

TEST(Progress, IsShownOnATerminal) {
  const std::string bar(15, '#'), rest(15, ' ');
  EXPECT_EQ(shown(true),
            "\r\033[K[" + bar + rest + "] episode 2 of 2, step 5 of at most 90, mean return -2.500\r\033[K");
  EXPECT_EQ(shown(false), "");
}

TEST(Status, EachHasAName) {
  EXPECT_STREQ(status_name(Status::kOk), "ok");
  EXPECT_STREQ(status_name(Status::kDeviceLost), "device_lost");
}

}  // namespace
}  // namespace hypgen
