// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "hypgen/core/interrupt.hpp"
#include "hypgen/core/progress.hpp"
#include "hypgen/core/status.hpp"

namespace hypgen {
namespace {

TEST(Interrupt, TheFirstIsNotedAndTheNextEndsTheProgram) {
  catch_interrupts();
  EXPECT_FALSE(interrupted());
  std::raise(SIGINT);
  EXPECT_TRUE(interrupted());
  EXPECT_EQ(std::signal(SIGINT, SIG_DFL), SIG_DFL);
  catch_interrupts();
  EXPECT_FALSE(interrupted());
  std::signal(SIGINT, SIG_DFL);
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
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  char text[1000];
  const ssize_t size = read(terminal, text, sizeof text);
  for (const int file : {terminal, theirs, before}) close(file);
  return std::string(text, size > 0 ? static_cast<std::size_t>(size) : 0);
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
