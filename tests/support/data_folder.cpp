#include "tests/support/data_folder.h"

#include <cstdlib>
#include <system_error>

namespace phiz::test {

std::filesystem::path phiz_data_folder() {
  const char* variable = std::getenv("PHIZ_DATA");
  const std::filesystem::path folder =
      variable && *variable ? std::filesystem::path(variable)
                            : std::filesystem::path(PHIZ_SOURCE_FOLDER) / ".." / "shared" / "data";
  std::error_code error;
  if (!std::filesystem::exists(folder / "subjects.json", error)) return {};
  return folder.lexically_normal();
}

}  // namespace phiz::test
