#include "store/lease.h"

#include <gtest/gtest.h>

#include <set>

#include "store/error.h"
#include "tests/store/memory_file_system.h"

namespace phiz {
namespace {

/// Several processes on several machines, and their clocks, as a test wants them.
class FakeProcesses final : public Processes {
 public:
  explicit FakeProcesses(ProcessIdentity self) : self_(std::move(self)) {}
  ProcessIdentity self() override { return self_; }
  bool is_alive(const ProcessIdentity& identity) override { return alive.contains(identity.pid); }
  double now_seconds() override { return now; }

  std::set<std::int64_t> alive;
  double now = 0;

 private:
  ProcessIdentity self_;
};

const LeaseOptions kNoHeartbeat{1e6, 30};

class LeaseTest : public ::testing::Test {
 protected:
  test::MemoryFileSystem disk_;
  Store store_ = Store::open_or_create(disk_, "/store");
  const Digest key_ = compute_digest("key");

  bool is_held(LeaseTable& table) { return std::holds_alternative<Lease>(table.try_acquire(key_)); }
};

TEST_F(LeaseTest, OnlyOneHasItUntilItIsGivenBack) {
  FakeProcesses one({"here", 1, 7}), two({"here", 2, 7});
  one.alive = two.alive = {1, 2};
  LeaseTable first(store_, one, kNoHeartbeat), second(store_, two, kNoHeartbeat);
  {
    const auto lease = first.try_acquire(key_);
    ASSERT_TRUE(std::holds_alternative<Lease>(lease));
    const auto refused = second.try_acquire(key_);
    ASSERT_TRUE(std::holds_alternative<LeaseHolder>(refused));
    EXPECT_EQ(std::get<LeaseHolder>(refused).pid, 1);
    EXPECT_FALSE(is_held(first)) << "another thread of the same process";
  }
  EXPECT_TRUE(is_held(second));
  EXPECT_TRUE(disk_.list_folder("/store/leases").empty());
}

TEST_F(LeaseTest, ADeadProcessOfThisMachineNeverBlocks) {
  FakeProcesses one({"here", 1, 7}), two({"here", 2, 7});
  one.alive = two.alive = {1, 2};
  LeaseTable second(store_, two, kNoHeartbeat);
  auto first = std::make_unique<LeaseTable>(store_, one, kNoHeartbeat);
  auto* leaked = new auto(first->try_acquire(key_));  // a killed process gives nothing back
  EXPECT_FALSE(is_held(second));
  two.alive = {2};
  EXPECT_TRUE(is_held(second));
  delete leaked;
}

TEST_F(LeaseTest, AnotherMachineIsDeadOnceItsHeartStopsByOurOwnClock) {
  FakeProcesses one({"there", 1, 7}), two({"here", 2, 7});
  one.now = 1e9;  // clocks of machines need not agree
  LeaseTable first(store_, one, kNoHeartbeat), second(store_, two, kNoHeartbeat);
  const auto lease = first.try_acquire(key_);
  EXPECT_FALSE(is_held(second));
  two.now = 29;
  first.renew();
  EXPECT_FALSE(is_held(second));
  two.now = 58;
  EXPECT_FALSE(is_held(second));
  two.now = 59.5;
  EXPECT_TRUE(is_held(second));
}

TEST_F(LeaseTest, ALeaseLeftByALivingProcessThatNoLongerHoldsItDiesToo) {
  FakeProcesses one({"here", 1, 7});
  one.alive = {1};
  LeaseTable first(store_, one, kNoHeartbeat), second(store_, one, kNoHeartbeat);
  const auto lease = first.try_acquire(key_);
  EXPECT_FALSE(is_held(second));
  one.now = 31;
  EXPECT_TRUE(is_held(second));
}

TEST_F(LeaseTest, AGarbledLeaseIsTakenOverInTheEnd) {
  FakeProcesses one({"here", 1, 7});
  LeaseTable table(store_, one, kNoHeartbeat);
  const std::string garbage = "{\"place\": 3";
  disk_.create_file(store_.layout().lease(key_), std::as_bytes(std::span(garbage)),
                    FileSystem::Mode::kWritable);
  EXPECT_FALSE(is_held(table));
  one.now = 31;
  EXPECT_TRUE(is_held(table));
}

TEST_F(LeaseTest, AFormerHolderDoesNotGiveBackWhatIsNoLongerIts) {
  FakeProcesses one({"there", 1, 7}), two({"here", 2, 7});
  two.alive = {2};
  LeaseTable first(store_, one, kNoHeartbeat), second(store_, two, kNoHeartbeat);
  auto slow = std::make_unique<std::variant<Lease, LeaseHolder>>(first.try_acquire(key_));
  EXPECT_FALSE(is_held(second));
  two.now = 40;
  const auto taken = second.try_acquire(key_);
  ASSERT_TRUE(std::holds_alternative<Lease>(taken));
  slow.reset();
  EXPECT_TRUE(disk_.find_status(store_.layout().lease(key_)));
}

TEST(RealProcesses, ThisProcessIsAliveAndItsNumberWithAnotherStartIsNot) {
  ProcessIdentity self = real_processes().self();
  EXPECT_TRUE(real_processes().is_alive(self));
  self.start += 1;
  EXPECT_FALSE(real_processes().is_alive(self));
}

}  // namespace
}  // namespace phiz
