#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/program.h"

namespace phiz::test {

/// A synthetic head scan and its fit, made once by the program itself and kept in the build folder: made when
/// first asked for, then found finished (`phiz fit` does nothing twice). Do not change anything in it.
struct FittedSubject {
  std::filesystem::path scan, truth, store;
  std::string name = "synth007";
};

/// Throws std::runtime_error with what the program said if it cannot be made.
FittedSubject fitted_subject();

/// A copy of the fitted subject's store, to be spoilt.
void copy_store(const std::filesystem::path& to);

/// The program with --store. Runs in the folder of the store's parent.
ProgramRun run_phiz(const std::filesystem::path& store, std::vector<std::string> arguments,
                    ProgramOptions options = {});

/// Lines of a text that begin with `start`.
int count_lines(const std::string& text, const std::string& start);

/// Digests of every current output, one a line: what two stores of equal work agree on.
std::string list_digests(const std::filesystem::path& store);

// Scans of things. Points are in mm.
void write_binary_ply(const std::filesystem::path& file, const std::vector<Eigen::Vector3f>& points);
void write_text(const std::filesystem::path& file, const std::string& text);
std::string read_bytes(const std::filesystem::path& file);

}  // namespace phiz::test
