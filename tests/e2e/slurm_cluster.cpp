#include "tests/e2e/slurm_cluster.h"

#include <arpa/inet.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/e2e/program.h"

namespace phiz::test {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kNodes = {"n1", "n2"};

std::string find_program(const std::string& name) {
  for (const char* folder : {"/usr/sbin", "/usr/bin", "/usr/local/sbin", "/usr/local/bin"}) {
    if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  }
  return {};
}

std::string host_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

/// A TCP port that nobody listens at now.
int free_port() {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ::bind(descriptor, reinterpret_cast<sockaddr*>(&address), length);
  ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length);
  ::close(descriptor);
  return ntohs(address.sin_port);
}

pid_t read_pid(const fs::path& file) {
  pid_t pid = 0;
  std::ifstream(file) >> pid;
  return pid;
}

std::string read_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What a process was started with in its environment.
bool has_variable(pid_t pid, const std::string& assignment) {
  const std::string variables = '\0' + read_file(fs::path("/proc") / std::to_string(pid) / "environ");
  return variables.find('\0' + assignment + '\0') != std::string::npos;
}

pid_t find_parent(pid_t pid) {
  const std::string text = read_file(fs::path("/proc") / std::to_string(pid) / "stat");
  const std::size_t end = text.rfind(") ");
  return end == std::string::npos ? 0 : std::atoi(text.c_str() + end + 4);
}

std::vector<pid_t> list_processes() {
  std::vector<pid_t> processes;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") == std::string::npos) processes.push_back(std::stoi(name));
  }
  return processes;
}

void end_process(const fs::path& pid_file) {
  const pid_t pid = read_pid(pid_file);
  if (pid <= 1) return;
  ::kill(pid, SIGTERM);
  for (int i = 0; i < 100 && ::kill(pid, 0) == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ::kill(pid, SIGKILL);
}

void start(const std::vector<std::string>& argv) {
  const ProgramRun run = run_program(argv);
  if (run.exit_code != 0) throw std::runtime_error(argv[0] + ": " + run.out + run.err);
}

}  // namespace

std::string SlurmCluster::find_obstacle() {
  for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol"}) {
    if (find_program(program).empty()) return std::string("Slurm is not installed: no ") + program;
  }
  if (::geteuid() != 0) return "slurmd wants root";
  return {};
}

SlurmCluster::SlurmCluster(int max_array_size) {
  // A short name: the paths of sockets hold 108 bytes.
  std::string name = (fs::temp_directory_path() / "slurm-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder: " + name);
  folder_ = name;
  fs::permissions(folder_, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                               fs::perms::others_read | fs::perms::others_exec);
  for (const char* part : {"run", "state", "log", "spool-n1", "spool-n2"})
    fs::create_directories(folder_ / part);
  std::ofstream key(folder_ / "munge.key", std::ios::binary);
  std::random_device random;
  for (int i = 0; i < 128; ++i) key.put(static_cast<char>(random()));
  key.close();
  fs::permissions(folder_ / "munge.key", fs::perms::owner_read | fs::perms::owner_write);
  write_configuration(max_array_size);
  ::setenv("SLURM_CONF", (folder_ / "slurm.conf").c_str(), 1);
  const auto option = [&](const std::string& name, const std::string& file) {
    return "--" + name + "=" + (folder_ / file).string();
  };
  start({find_program("munged"), "--force", option("key-file", "munge.key"),
         option("socket", "run/munge.socket"), option("pid-file", "run/munged.pid"),
         option("log-file", "log/munged.log"), option("seed-file", "run/munged.seed")});
  start({find_program("slurmctld"), "-c"});
  for (const std::string& node : kNodes) start_node(node);
  for (int i = 0; i < 300; ++i) {
    const std::string said = ask({"sinfo", "--noheader", "--format=%T %D"});
    if (said.starts_with("idle 2")) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  throw std::runtime_error("Slurm did not come up: " + ask({"sinfo"}) +
                           read_file(folder_ / "log/slurmctld.log"));
}

SlurmCluster::~SlurmCluster() {
  ask({"scancel", "--signal=KILL", "--user=root"});
  end_process(folder_ / "run/slurmctld.pid");
  for (const std::string& node : kNodes) kill_node(node);
  end_process(folder_ / "run/munged.pid");
  ::unsetenv("SLURM_CONF");
  std::error_code error;
  fs::remove_all(folder_, error);
}

void SlurmCluster::write_configuration(int max_array_size) const {
  std::ofstream out(folder_ / "slurm.conf");
  const std::string root = folder_.string(), host = host_name();
  out << "ClusterName=test\nSlurmctldHost=" << host << "(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\n"
      << "AuthType=auth/munge\nAuthInfo=socket=" << root << "/run/munge.socket\nCredType=cred/munge\n"
      << "MpiDefault=none\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n"
      << "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n"
      << "SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0,sched_min_interval=0\n"
      << "AccountingStorageType=accounting_storage/none\nJobAcctGatherType=jobacct_gather/none\n"
      << "SwitchType=switch/none\nReturnToService=2\nSlurmdTimeout=10\nKillWait=3\nMinJobAge=300\n"
      << "MaxArraySize=" << max_array_size << "\nSlurmctldPort=" << free_port() << "\n"
      << "SlurmctldPidFile=" << root << "/run/slurmctld.pid\nSlurmdPidFile=" << root << "/run/slurmd-%n.pid\n"
      << "StateSaveLocation=" << root << "/state\nSlurmdSpoolDir=" << root << "/spool-%n\n"
      << "SlurmctldLogFile=" << root << "/log/slurmctld.log\nSlurmdLogFile=" << root
      << "/log/slurmd-%n.log\n";
  for (const std::string& node : kNodes) {
    out << "NodeName=" << node << " NodeHostname=" << host << " NodeAddr=127.0.0.1 Port=" << free_port()
        << " CPUs=1 RealMemory=2000\n";
  }
  out << "PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP\n";
}

std::string SlurmCluster::ask(const std::vector<std::string>& argv) const {
  return run_program(argv).out;
}

std::vector<std::string> SlurmCluster::list_queue() const {
  std::vector<std::string> lines;
  std::istringstream text(ask({"squeue", "--noheader", "--array", "--format=%F_%K %T %N"}));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

void SlurmCluster::release_requeued() const {
  for (const std::string& line : list_queue()) {
    if (line.find(" PENDING") == std::string::npos) continue;
    ask({"scontrol", "update", "JobId=" + line.substr(0, line.find(' ')), "StartTime=now"});
  }
}

void SlurmCluster::start_node(const std::string& name) {
  start({find_program("slurmd"), "-N", name, "-c"});
}

void SlurmCluster::kill_node(const std::string& name) {
  const pid_t node = read_pid(folder_ / ("run/slurmd-" + name + ".pid"));
  if (node > 1) ::kill(node, SIGKILL);
  // The jobs of this cluster on that node, and the step managers above them.
  for (const pid_t pid : list_processes()) {
    if (!has_variable(pid, "SLURM_CONF=" + (folder_ / "slurm.conf").string()) ||
        !has_variable(pid, "SLURMD_NODENAME=" + name)) {
      continue;
    }
    const pid_t parent = find_parent(pid);
    const std::string above = read_file(fs::path("/proc") / std::to_string(parent) / "cmdline");
    if (above.find("slurmstepd") != std::string::npos) ::kill(parent, SIGKILL);
    ::kill(pid, SIGKILL);
  }
}

}  // namespace phiz::test
