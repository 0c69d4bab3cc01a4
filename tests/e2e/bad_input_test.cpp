#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "tests/e2e/subject.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

namespace fs = std::filesystem;

constexpr int kBadInput = 4, kNoSpace = 13, kRejected = 14;
using Points = std::vector<Eigen::Vector3f>;

/// The program on a store with a finished subject; whatever is done to it, that subject must stay finished.
class BadInput : public testing::Test {
 protected:
  void SetUp() override { copy_store(store_); }

  void TearDown() override {
    const ProgramRun verify = run_phiz(store_, {"store", "verify"});
    EXPECT_EQ(verify.exit_code, 0) << verify.out << verify.err;
    const ProgramRun again = run_phiz(store_, {"fit", fitted_subject().scan.string()});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_NE(again.out.find("nothing to do"), std::string::npos) << again.out;
  }

  void expect_refusal(const ProgramRun& run, int code) {
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_EQ(count_lines(run.err, "error:"), 1) << run.err;
    EXPECT_LE(count_lines(run.err, "hint:"), 1) << run.err;
    EXPECT_TRUE(run.out.empty()) << run.out;
  }

  void expect_refusal(const fs::path& scan, int code) {
    SCOPED_TRACE(scan.filename().string());
    expect_refusal(run_phiz(store_, {"fit", scan.string(), "-q"}), code);
  }

  fs::path write_points(const std::string& name, const Points& points) {
    write_binary_ply(folder_ / name, points);
    return folder_ / name;
  }

  fs::path write(const std::string& name, const std::string& text) {
    write_text(folder_ / name, text);
    return folder_ / name;
  }

  TempFolder folder_;
  const fs::path store_ = folder_ / "store";
};

Eigen::Vector3f random_point(double low, double high) {
  return {static_cast<float>(random().uniform(low, high)), static_cast<float>(random().uniform(low, high)),
          static_cast<float>(random().uniform(low, high))};
}

Points make_points(int count, const std::function<Eigen::Vector3f()>& make) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(make());
  return points;
}

Eigen::Vector3f random_direction() {
  while (true) {
    const Eigen::Vector3f point = random_point(-1, 1);
    if (point.norm() > 0.1f && point.norm() < 1) return point.normalized();
  }
}

TEST_F(BadInput, EmptyFile) {
  expect_refusal(write("empty.ply", ""), kBadInput);
}

TEST_F(BadInput, MissingFileAndFolder) {
  expect_refusal(folder_ / "nothing.ply", kBadInput);
  fs::create_directory(folder_ / "folder.ply");
  expect_refusal(folder_ / "folder.ply", kBadInput);
}

TEST_F(BadInput, NoNumbers) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInfinity = std::numeric_limits<float>::infinity();
  expect_refusal(write_points("nan.ply", Points(1000, Eigen::Vector3f(kNan, 0, kNan))), kBadInput);
  expect_refusal(write_points("infinite.ply", Points(1000, Eigen::Vector3f(kInfinity, -kInfinity, 0))),
                 kBadInput);
}

TEST_F(BadInput, TooLittle) {
  expect_refusal(write_points("same.ply", Points(5000, Eigen::Vector3f(1, 2, 3))), kBadInput);
  expect_refusal(write_points("ten.ply", make_points(10, [] { return random_point(-100, 100); })), kBadInput);
}

TEST_F(BadInput, Plane) {
  const auto plane = [] {
    return Eigen::Vector3f(random_point(-100, 100).cwiseProduct(Eigen::Vector3f(1, 1, 0)));
  };
  expect_refusal(write_points("plane.ply", make_points(20000, plane)), kRejected);
}

TEST_F(BadInput, Sphere) {
  const auto sphere = [] { return Eigen::Vector3f(100 * random_direction()); };
  expect_refusal(write_points("sphere.ply", make_points(20000, sphere)), kRejected);
}

TEST_F(BadInput, Cube) {
  const auto cube = [] {
    Eigen::Vector3f point = random_point(-100, 100);
    point[static_cast<int>(random().below(3))] = random().below(2) == 0 ? -100.0f : 100.0f;
    return point;
  };
  expect_refusal(write_points("cube.ply", make_points(20000, cube)), kRejected);
}

/// Body, neck, head and four legs as ellipsoids.
TEST_F(BadInput, HorseLikeBlob) {
  const std::array<std::array<Eigen::Vector3f, 2>, 7> parts = {
      {{Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(120, 45, 40)},
       {Eigen::Vector3f(130, 60, 0), Eigen::Vector3f(30, 60, 20)},
       {Eigen::Vector3f(165, 110, 0), Eigen::Vector3f(45, 20, 18)},
       {Eigen::Vector3f(80, -90, 25), Eigen::Vector3f(12, 70, 12)},
       {Eigen::Vector3f(80, -90, -25), Eigen::Vector3f(12, 70, 12)},
       {Eigen::Vector3f(-80, -90, 25), Eigen::Vector3f(12, 70, 12)},
       {Eigen::Vector3f(-80, -90, -25), Eigen::Vector3f(12, 70, 12)}}};
  const auto horse = [&] {
    const auto& part = parts[random().below(parts.size())];
    return Eigen::Vector3f(part[0] + part[1].cwiseProduct(random_direction()));
  };
  expect_refusal(write_points("horse.ply", make_points(40000, horse)), kRejected);
}

TEST_F(BadInput, Truncated) {
  const std::string whole = read_bytes(fitted_subject().scan);
  const std::size_t header = whole.find("end_header\n") + 11;
  std::vector<std::size_t> sizes;
  for (std::size_t size = 1; size < header; size += 13) sizes.push_back(size);
  sizes.push_back(header);
  for (int i = 0; i < 4; ++i) sizes.push_back(header + random().below(whole.size() - header - 1));
  for (const std::size_t size : sizes) expect_refusal(write("cut.ply", whole.substr(0, size)), kBadInput);
}

TEST_F(BadInput, LyingHeader) {
  const std::string rest = "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const char* count : {"4294967295", "18446744073709551615", "-1", "many"}) {
    expect_refusal(write("lie.ply", "ply\nformat binary_little_endian 1.0\nelement vertex " +
                                        std::string(count) + rest + std::string(1200, '\0')),
                   kBadInput);
  }
}

TEST_F(BadInput, TextInNumbers) {
  expect_refusal(write("words.xyz", "1 2 3\n4 five 6\n7 8 9\n"), kBadInput);
  expect_refusal(write("words.obj", "v 1 2 3\nv 4 5 six\nf 1 2 2\n"), kBadInput);
  expect_refusal(write("words.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                       "property float z\nend_header\n1 two 3\n"),
                 kBadInput);
}

TEST_F(BadInput, MissingTemplate) {
  const std::string scan = fitted_subject().scan.string();
  expect_refusal(run_phiz(store_, {"fit", scan, "-q", "--template", (folder_ / "none.obj").string()}),
                 kBadInput);
}

TEST_F(BadInput, TemplateWithoutBoxes) {
  const fs::path head = fs::path(PHIZ_SOURCE_FOLDER) / "samples" / "generic_head";
  fs::copy_file(head / "head.obj", folder_ / "plain.obj");
  std::string json = read_bytes(head / "head.json");
  const std::size_t begin = json.find("\"boxes\""), open = json.find('{', begin);
  ASSERT_NE(open, std::string::npos);
  std::size_t end = open;
  for (int depth = 0; end < json.size(); ++end) {
    depth += json[end] == '{' ? 1 : json[end] == '}' ? -1 : 0;
    if (depth == 0) break;
  }
  json.replace(open, end + 1 - open, "{}");
  write("plain.json", json);
  const std::string scan = fitted_subject().scan.string();
  expect_refusal(run_phiz(store_, {"fit", scan, "-q", "--template", (folder_ / "plain.obj").string()}),
                 kBadInput);
}

/// The program as somebody without rights; empty where that cannot be had.
std::vector<std::string> without_rights(const fs::path& probe) {
  std::vector<std::string> words;
  if (::geteuid() == 0) words = {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"};
  words.push_back(phiz_program().string());
  std::vector<std::string> version = words;
  version.push_back("--version");
  try {
    if (run_program(version, {probe, {}, {}}).exit_code == 0) return words;
  } catch (const std::system_error&) {
  }
  return {};
}

TEST_F(BadInput, NoPermission) {
  std::vector<std::string> words = without_rights("/");
  if (words.empty()) GTEST_SKIP() << "cannot run the program without rights here";
  ::chmod(folder_.path().c_str(), 0755);
  const fs::path locked = folder_ / "locked.ply";
  fs::copy_file(fitted_subject().scan, locked);
  ::chmod(locked.c_str(), 0);
  words.insert(words.end(), {"fit", "-q", locked.string(), "--store", (folder_ / "new").string()});
  const ProgramRun run = run_program(words, {"/", {}, {}});
  EXPECT_TRUE(run.exit_code == kBadInput || run.exit_code == kNoSpace) << run.exit_code << run.err;
  EXPECT_EQ(count_lines(run.err, "error:"), 1) << run.err;
}

TEST_F(BadInput, StoreThatCannotBeWritten) {
  std::vector<std::string> words = without_rights("/");
  if (words.empty()) GTEST_SKIP() << "cannot run the program without rights here";
  ::chmod(folder_.path().c_str(), 0555);
  const fs::path scan = fs::temp_directory_path() / ("phiz-open-" + std::to_string(::getpid()) + ".ply");
  fs::copy_file(fitted_subject().scan, scan, fs::copy_options::overwrite_existing);
  ::chmod(scan.c_str(), 0644);
  words.insert(words.end(), {"fit", "-q", scan.string(), "--store", (folder_ / "new").string()});
  expect_refusal(run_program(words, {"/", {}, {}}), kNoSpace);
  ::chmod(folder_.path().c_str(), 0755);
  fs::remove(scan);
}

/// A disk of one megabyte for the store, in a mount namespace of its own.
TEST_F(BadInput, FullDisk) {
  fs::create_directory(folder_ / "small");
  const std::string small = (folder_ / "small").string();
  const std::string mount = "mount -t tmpfs -o size=1m phiz '" + small + "'";
  if (run_program({"unshare", "-m", "sh", "-c", mount}).exit_code != 0)
    GTEST_SKIP() << "cannot mount a small disk here";
  const std::string program = phiz_program().string(), scan = fitted_subject().scan.string();
  const std::string command = program + " fit -q --store '" + small + "/store' '" + scan + "'";
  const std::string check = program + " store verify -q --store '" + small + "/store' >/dev/null || exit 99";
  const ProgramRun run = run_program(
      {"unshare", "-m", "sh", "-c", mount + " && { " + command + "; code=$?; " + check + "; exit $code; }"});
  expect_refusal(run, kNoSpace);
}

}  // namespace
}  // namespace phiz::test
