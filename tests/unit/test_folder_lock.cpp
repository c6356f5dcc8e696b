// SPDX-License-Identifier: GPL-3.0-or-later
// Takeover of locks: owners on other hosts, in other process namespaces, and in other starts and steps of a
// SLURM job.
#include "common/whole_number.h"
#include "ensemble/folder_lock.h"

#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;
using ::testing::Optional;

constexpr double just_touched = 5;
constexpr double forgotten = LockFile::lifetime + 1;

/// Number of a process that has ended.
long ended_process() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  return child;
}

/// A dead process of this host and namespace, outside SLURM.
LockOwner dead() {
  LockOwner owner = LockOwner::self();
  owner.job = owner.step = "-";
  owner.restart = 0;
  owner.process = ended_process();
  return owner;
}

LockOwner in_job(LockOwner owner, const char* job, std::uint64_t restart, const char* step) {
  owner.job = job;
  owner.restart = restart;
  owner.step = step;
  return owner;
}

LockOwner on_host(LockOwner owner, const char* host) {
  owner.host = host;
  owner.boot = std::string("boot-of-") + host;
  return owner;
}

TEST(FolderLock, AProcessOfThisHostAndNamespaceIsLookedUp) {
  const LockOwner self = LockOwner::self();
  EXPECT_EQ(why_stale(self, self, forgotten), std::nullopt) << "it lives, however long it has slept";
  EXPECT_THAT(why_stale(dead(), self, just_touched), Optional(HasSubstr("has ended without removing it")));
  LockOwner former = self;
  former.start = "1";
  EXPECT_TRUE(why_stale(former, self, just_touched)) << "another process has its number now";
  former.start = "0";
  EXPECT_FALSE(why_stale(former, self, just_touched)) << "its start is not known: it may be that process";
}

TEST(FolderLock, ProcessNumbersOfOtherNamespacesAndMachinesSayNothing) {
  const LockOwner self = LockOwner::self();
  LockOwner contained = dead();
  contained.pid_namespace = "4026539999";
  EXPECT_EQ(why_stale(contained, self, just_touched), std::nullopt);
  EXPECT_THAT(why_stale(contained, self, forgotten), Optional(HasSubstr("has not updated it for 10 min")));
  LockOwner namesake = dead();
  namesake.boot = "another";
  EXPECT_EQ(why_stale(namesake, self, just_touched), std::nullopt) << "another machine of the same name";
  EXPECT_EQ(why_stale(on_host(dead(), "elsewhere"), self, just_touched), std::nullopt);
  EXPECT_TRUE(why_stale(on_host(dead(), "elsewhere"), self, forgotten));
}

TEST(FolderLock, StepsOfOneStartOfAJobLeaveEachOtherAlone) {
  const LockOwner here = LockOwner::self();
  const LockOwner there = on_host(dead(), "node2");
  for (const std::uint64_t restart : {0, 2}) {
    const LockOwner self = in_job(here, "56", restart, "0");
    EXPECT_EQ(why_stale(in_job(there, "56", restart, "1"), self, just_touched), std::nullopt);
    EXPECT_EQ(why_stale(in_job(there, "56", restart, "-"), self, just_touched), std::nullopt);
    EXPECT_TRUE(why_stale(in_job(there, "56", restart, "1"), self, forgotten));
    EXPECT_TRUE(why_stale(in_job(dead(), "56", restart, "1"), self, just_touched)) << "here it is looked up";
  }
}

TEST(FolderLock, AnEarlierStartOfTheJobHasEnded) {
  const LockOwner self = in_job(LockOwner::self(), "56", 1, "0");
  const LockOwner there = on_host(dead(), "node2");
  EXPECT_THAT(why_stale(in_job(there, "56", 0, "0"), self, just_touched),
              Optional(HasSubstr("is an earlier start of this job")));
  EXPECT_EQ(why_stale(in_job(there, "57", 0, "0"), self, just_touched), std::nullopt) << "another job";
  EXPECT_EQ(why_stale(in_job(there, "56", 2, "0"), self, just_touched), std::nullopt) << "a later start";
  LockOwner contained = in_job(dead(), "56", 0, "0");
  contained.pid_namespace = "4026539999";
  EXPECT_TRUE(why_stale(contained, self, just_touched));
  EXPECT_EQ(why_stale(in_job(LockOwner::self(), "56", 0, "0"), self, just_touched), std::nullopt)
      << "it lives, whatever SLURM says";
  EXPECT_EQ(why_stale(there, in_job(LockOwner::self(), "-", 1, "-"), just_touched), std::nullopt);
}

TEST(FolderLock, OwnersAreReadAsTheyWereWritten) {
  const LockOwner self = in_job(LockOwner::self(), "56", 3, "2");
  EXPECT_THAT(LockOwner::parse(self.text()), Optional(self));
  EXPECT_FALSE(self.boot.empty() || self.pid_namespace.empty() || self.start == "0");
  EXPECT_THAT(self.describe(), HasSubstr(", SLURM job 56 step 2, restart 3"));
  for (const char* text : {"", "host", "host a\n", "host a\nprocess 12\nstart 34\n",
                           "host a\nprocess -12\nstart 34\njob -\n", "host a\nprocess 1x\nstart 34\njob -\n"})
    EXPECT_EQ(LockOwner::parse(text), std::nullopt) << text;
  EXPECT_EQ(why_stale(std::nullopt, self, just_touched), std::nullopt) << "it may be on its way";
  EXPECT_TRUE(why_stale(std::nullopt, self, forgotten));
}

TEST(FolderLock, LocksOfEarlierVersionsAreUnderstood) {
  const auto owner = LockOwner::parse("host node2\nprocess 12\nstart 34\njob 56\n");
  ASSERT_TRUE(owner);
  EXPECT_EQ(owner->restart, 0U);
  const LockOwner first = in_job(LockOwner::self(), "56", 0, "0");
  EXPECT_EQ(why_stale(owner, first, just_touched), std::nullopt) << "it may be another step of this start";
  EXPECT_TRUE(why_stale(owner, first, forgotten));
  EXPECT_TRUE(why_stale(owner, in_job(first, "56", 1, "0"), just_touched));
  // On this host the process is looked up, as those versions did.
  LockOwner here = dead();
  here.boot = here.pid_namespace = "";
  EXPECT_TRUE(why_stale(here, first, just_touched));
  here = LockOwner::self();
  here.boot = here.pid_namespace = "";
  EXPECT_FALSE(why_stale(here, first, forgotten));
}

TEST(FolderLock, ALockThatWasTakenOverIsNotRemovedByItsFormerOwner) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "lock-0-2";
  {
    const FolderLock lock(folder.path(), {0, 2});
    std::ofstream(file) << on_host(dead(), "elsewhere").text();
  }
  EXPECT_TRUE(std::filesystem::exists(file));
}

/// The error on writing a file into the folder of a lock; empty if allowed.
std::string loss(const LockMark& mark) {
  try {
    mark.require();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST(FolderLock, IsLostWithItsFolder) {
  const test::TemporaryFolder parent;
  const auto folder = parent.path() / "out", moved = parent.path() / "moved";
  {
    const FolderLock lock(folder, {0, 2});
    EXPECT_EQ(loss(lock.mark()), "");
    std::filesystem::rename(folder, moved);
    EXPECT_THAT(loss(lock.mark()), HasSubstr("lock-0-2 is gone: it or its folder was moved or removed"));
    std::filesystem::create_directory(folder);
    EXPECT_THAT(loss(lock.mark()), HasSubstr("is gone"));
    std::ofstream(folder / "lock-0-2") << on_host(dead(), "elsewhere").text();
    EXPECT_THAT(loss(lock.mark()), HasSubstr("is another run's"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(moved)) << "the lock goes wherever its folder is";
  EXPECT_TRUE(std::filesystem::exists(folder / "lock-0-2"));
}

TEST(FolderLock, MakesItsFolderAndLeavesNoEmptyOne) {
  const test::TemporaryFolder parent;
  const auto folder = parent.path() / "out";
  { const FolderLock lock(folder, {0, 2}); }
  EXPECT_FALSE(std::filesystem::exists(folder));
  {
    const FolderLock lock(folder, {0, 2});
    std::ofstream(folder / "input.toml") << "samples = 3\n";
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "input.toml"));
}

TEST(FolderLock, IsARegularFile) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "lock-0-2";
  const auto refusal = [&](SampleRange range) -> std::string {
    try {
      const FolderLock lock(folder.path(), range);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  };
  for (const SampleRange range : {SampleRange{0, 2}, SampleRange{1, 1}}) {
    std::filesystem::create_directory(file);
    EXPECT_THAT(refusal(range), HasSubstr("lock-0-2 is a folder, not a lock; remove it"));
    std::filesystem::remove(file);
    ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
    EXPECT_THAT(refusal(range), HasSubstr("is a named pipe"));
    std::filesystem::remove(file);
    std::filesystem::create_symlink("/dev/null", file);
    EXPECT_THAT(refusal(range), HasSubstr("is a symbolic link"));
    std::filesystem::remove(file);
  }
}

TEST(FolderLock, RangesAreDigitsOnly) {
  const test::TemporaryFolder folder;
  // The first two are not locks of ranges; the last one is, from another host, and overlaps.
  for (const char* name : {"lock-0--1", "lock-+0-2", "lock-1-2"})
    std::ofstream(folder.path() / name) << on_host(dead(), "elsewhere").text();
  EXPECT_NO_THROW(FolderLock(folder.path(), {0, 0}));
  EXPECT_THROW(FolderLock(folder.path(), {2, 3}), std::runtime_error);
}

TEST(WholeNumber, IsAllOfTheText) {
  EXPECT_EQ(whole_number<std::uint64_t>("18446744073709551615"), 18446744073709551615U);
  EXPECT_EQ(whole_number<int>("-3"), -3);
  for (const char* text : {"", " 1", "1 ", "+1", "-1", "0x1", "1.0", "1e3", "18446744073709551616"})
    EXPECT_EQ(whole_number<std::uint64_t>(text), std::nullopt) << text;
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
