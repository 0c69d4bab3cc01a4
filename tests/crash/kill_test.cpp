// Real processes on the real disk, killed with SIGKILL at random instants. PHIZ_TEST_KILLS sets how many
// (default 50).

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <thread>

#include "orchestrator/app.h"
#include "orchestrator/commands/commands.h"
#include "store/verify.h"
#include "tests/orchestrator/fake_phiz.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"

namespace phiz {
namespace {

namespace fs = std::filesystem;

int kill_count() {
  const char* text = std::getenv("PHIZ_TEST_KILLS");
  return text != nullptr ? std::max(1, std::atoi(text)) : 50;
}

void write_text(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

/// A folder with a generic head and scans, and phiz processes at work in it.
class Workshop {
 public:
  explicit Workshop(fs::path folder) : folder_(std::move(folder)) {
    write_text(folder_ / "head/head.obj", "v 0 0 0\n");
    write_text(folder_ / "head/head.json", "{}");
    for (const char* name : {"a", "b", "c"}) write_text(scan(name), std::string("words of scan ") + name);
  }

  fs::path scan(const std::string& name) const { return folder_ / (name + ".xyz"); }
  fs::path log() const { return folder_ / "events.txt"; }
  Store open_store() const { return Store::open(real_file_system(), folder_ / "store"); }

  /// Starts `phiz fit` on the scans in a process of its own.
  pid_t start(const std::vector<std::string>& names) const {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(run(names));
    return child;
  }

  std::vector<std::string> read_events() const {
    std::vector<std::string> lines;
    std::ifstream file(log());
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }

  /// Output digests of every subject's stages.
  std::map<std::string, std::string> digests() const {
    std::map<std::string, std::string> all;
    const Store store = open_store();
    for (const std::string& name : store.list_subjects()) {
      const SubjectRecord record = store.find_subject(name).value();
      for (const auto& [stage, key] : record.results) {
        const auto result = store.find_done_result(key);
        if (!result) continue;
        for (const auto& [output, object] : result->outputs) {
          all[name + "/" + stage + "/" + output] = compute_digest(store.read_object(object.digest)).hex();
        }
      }
    }
    return all;
  }

 private:
  int run(const std::vector<std::string>& names) const {
    test::FakeStages stages;
    stages.step_milliseconds = 3;
    stages.on_event = [this](const std::string& event) {
      std::ofstream(log(), std::ios::app) << event + "\n";
    };
    const Pipeline pipeline(test::make_fake_tasks(stages));
    const std::vector<Command> commands = list_light_commands();
    const auto find_variable = [](const std::string&) { return std::optional<std::string>(); };
    std::ofstream silence("/dev/null");
    const Environment environment{silence,
                                  silence,
                                  real_file_system(),
                                  real_processes(),
                                  pipeline,
                                  commands,
                                  stages.stop,
                                  find_variable,
                                  {},
                                  false,
                                  false};
    std::vector<std::string> arguments = {
        "fit",           "-j", "2", "--set", "join.steps=12", "--store", folder_ / "store", "--template",
        folder_ / "head"};
    for (const std::string& name : names) arguments.push_back(scan(name));
    return run_phiz(arguments, environment);
  }

  fs::path folder_;
};

/// Waits up to `milliseconds`, then kills. The exit code, or nothing if it was killed.
std::optional<int> wait_or_kill(pid_t child, double milliseconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double, std::milli>(milliseconds);
  int status = 0;
  while (std::chrono::steady_clock::now() < end) {
    if (::waitpid(child, &status, WNOHANG) == child) return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) return std::nullopt;
  return WEXITSTATUS(status);
}

constexpr double kForEver = 60'000;

struct Undisturbed {
  std::map<std::string, std::string> digests;
  double milliseconds = 0;
};

Undisturbed run_undisturbed(const std::vector<std::string>& names) {
  const test::TempFolder folder;
  const Workshop workshop(folder.path());
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(wait_or_kill(workshop.start(names), kForEver), 0);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
  return {workshop.digests(), took.count()};
}

/// The number after `word` in the last event that begins with it, among events [begin, end); -1 if there is
/// none.
int last_number(const std::vector<std::string>& events, std::size_t begin, std::size_t end,
                const std::string& word) {
  for (std::size_t i = end; i-- > begin;) {
    if (events[i].starts_with(word + " ")) return std::atoi(events[i].c_str() + word.size() + 1);
  }
  return -1;
}

TEST(Kill, FinishedStagesAreNotRepeatedAndTheLongOneContinues) {
  const Undisturbed undisturbed = run_undisturbed({"a"});
  int kills = 0;
  while (kills < kill_count()) {
    const test::TempFolder folder;
    const Workshop workshop(folder.path());
    std::set<std::string> done;
    for (std::optional<int> code; !code;) {
      const std::size_t begin = workshop.read_events().size();
      const int saved_before = last_number(workshop.read_events(), 0, begin, "saved");
      code = wait_or_kill(workshop.start({"a"}), test::random().uniform(0, undisturbed.milliseconds));
      kills += !code;
      EXPECT_EQ(code.value_or(0), 0);
      const auto events = workshop.read_events();
      for (std::size_t i = begin; i < events.size(); ++i) {
        EXPECT_FALSE(events[i].starts_with("begin ") && done.contains(events[i].substr(6)))
            << events[i] << " again";
      }
      const int resumed = last_number(events, begin, events.size(), "resumed");
      EXPECT_TRUE(resumed < 0 || resumed >= saved_before) << "what a save returned for is not lost";
      if (!fs::exists(folder / "store/phiz-store.json")) continue;
      const Store store = workshop.open_store();
      const VerifyReport report = verify_store(store);
      for (const StoreDamage& damage : report.damages) ADD_FAILURE() << damage.what << ": " << damage.cause;
      for (const Digest& key : store.list_results()) done.insert(store.find_done_result(key).value().stage());
    }
    EXPECT_EQ(workshop.digests(), undisturbed.digests);
    EXPECT_TRUE(fs::is_empty(folder / "store/checkpoints"));
    if (HasFailure()) break;
  }
}

TEST(Kill, FourProcessesOnOneStoreEndWellWhoeverDies) {
  const std::vector<std::string> orders[] = {{"c", "a", "b"}, {"a", "b", "c"}};
  const Undisturbed undisturbed = run_undisturbed({"a", "b", "c"});
  for (int kills = 0; kills < kill_count();) {
    const test::TempFolder folder;
    const Workshop workshop(folder.path());
    std::set<std::string> seen;
    for (int round = 0; round < 6; ++round) {
      std::vector<pid_t> children;
      for (int i = 0; i < 4; ++i) children.push_back(workshop.start(orders[i % 2]));
      for (const pid_t child : children) {
        const auto code = wait_or_kill(child, test::random().uniform(0, undisturbed.milliseconds / 3));
        EXPECT_EQ(code.value_or(0), 0);
        kills += !code;
      }
      if (!fs::exists(folder / "store/phiz-store.json")) continue;
      EXPECT_TRUE(verify_store(workshop.open_store()).ok());
      std::set<std::string> results;
      for (const Digest& key : workshop.open_store().list_results()) results.insert(key.hex());
      for (const std::string& key : seen) EXPECT_TRUE(results.contains(key)) << key << " was lost";
      seen = results;
    }
    const auto begin = std::chrono::steady_clock::now();
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) children.push_back(workshop.start(orders[i % 2]));
    for (const pid_t child : children) EXPECT_EQ(wait_or_kill(child, kForEver), 0);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(took.count(), 25) << "a dead process's lease must not be waited for";
    EXPECT_EQ(workshop.digests(), undisturbed.digests);
    EXPECT_TRUE(verify_store(workshop.open_store()).ok());
    for (const auto& lease : fs::directory_iterator(folder / "store/leases"))
      EXPECT_TRUE(is_temporary_name(lease.path().filename())) << lease.path() << " stays";
    EXPECT_TRUE(fs::is_empty(folder / "store/checkpoints"));
    if (HasFailure()) break;
  }
}

TEST(Creation, ManyProcessesThatMakeOneStoreAllHaveIt) {
  for (int round = 0; round < 40; ++round) {
    const test::TempFolder folder;
    std::vector<pid_t> children;
    for (int i = 0; i < 8; ++i) {
      const pid_t child = ::fork();
      if (child == 0) {
        try {
          Store::open_or_create(real_file_system(), folder / "store").list_subjects();
          ::_exit(0);
        } catch (const std::exception&) {
          ::_exit(1);
        }
      }
      children.push_back(child);
    }
    for (const pid_t child : children) EXPECT_EQ(wait_or_kill(child, kForEver), 0);
    EXPECT_TRUE(verify_store(Store::open(real_file_system(), folder / "store")).ok());
    if (HasFailure()) break;
  }
}

}  // namespace
}  // namespace phiz
