#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace phiz::test {

/// A real Slurm of two nodes on this machine's loopback, in a temporary folder: munged, slurmctld, two
/// slurmd. Sets SLURM_CONF for this process and those it starts. Everything it started is ended by the
/// destructor, by number.
class SlurmCluster {
 public:
  /// Why there can be none here (programs that are not installed, not root); empty if there can.
  static std::string find_obstacle();

  /// Throws std::runtime_error if it does not come up within half a minute.
  explicit SlurmCluster(int max_array_size);
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  /// stdout of one of Slurm's programs.
  std::string ask(const std::vector<std::string>& argv) const;

  /// "<array>_<task> <state> <node>" of what waits or runs.
  std::vector<std::string> list_queue() const;

  /// Requeued jobs are held back for two minutes: no longer.
  void release_requeued() const;

  /// SIGKILL to all of a node at once: its slurmd, the step managers, the jobs. Slurm finds out by itself.
  void kill_node(const std::string& name);
  void start_node(const std::string& name);

 private:
  void write_configuration(int max_array_size) const;
  std::filesystem::path folder_;
};

}  // namespace phiz::test
