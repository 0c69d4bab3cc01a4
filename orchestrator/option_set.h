#pragma once

#include <optional>
#include <string>
#include <vector>

namespace phiz {

/// Where a command declares its options. A thin door to CLI11, which stays in one source. `names` is
/// "-o,--output"; targets must live until the command has run. Targets keep their value where the user gives
/// none.
class OptionSet {
 public:
  virtual ~OptionSet() = default;
  virtual void add_flag(const std::string& names, bool& target, const std::string& doc) = 0;
  virtual void add_text(const std::string& names, std::optional<std::string>& target,
                        const std::string& doc) = 0;
  virtual void add_integer(const std::string& names, std::optional<int>& target, const std::string& doc) = 0;
  virtual void add_number(const std::string& names, std::optional<double>& target,
                          const std::string& doc) = 0;
  virtual void add_texts(const std::string& names, std::vector<std::string>& target,
                         const std::string& doc) = 0;
  virtual void require(const std::string& names) = 0;  ///< of an option declared before

  // Words without a dash, in the order of declaration.
  virtual void add_positional(const std::string& name, std::string& target,
                              const std::string& doc) = 0;  ///< required
  virtual void add_positionals(const std::string& name, std::vector<std::string>& target,
                               const std::string& doc) = 0;
};

}  // namespace phiz
