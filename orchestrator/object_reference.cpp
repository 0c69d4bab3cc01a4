#include "orchestrator/object_reference.h"

#include "orchestrator/error.h"

namespace phiz {
namespace {

OutputObject find_by_digest(const Store& store, const Digest& digest) {
  const auto size = store.find_object_size(digest);
  if (!size) throw UsageError("the store has no object " + digest.hex());
  return {digest, *size};
}

}  // namespace

OutputObject find_referenced_object(const Session& session, const Store& store,
                                    const std::string& reference) {
  if (const auto digest = parse_digest(reference)) return find_by_digest(store, *digest);
  const std::size_t first = reference.find('/');
  if (first == std::string::npos) {
    throw UsageError("'" + reference + "' names no object",
                     "use SUBJECT/OUTPUT, SUBJECT/STAGE/OUTPUT or a digest; see phiz store ls");
  }
  const std::size_t last = reference.rfind('/');
  const SubjectRecord record = session.get_subject(store, reference.substr(0, first));
  const std::string stage = last > first ? reference.substr(first + 1, last - first - 1) : "";
  const std::string output = reference.substr(last + 1);
  std::vector<OutputObject> found;
  for (const auto& [name, key] : record.results) {
    if (!stage.empty() && stage != name) continue;
    const auto result = store.find_result(key);
    if (!result) continue;
    const auto object = result->outputs.find(output);
    if (object != result->outputs.end()) found.push_back(object->second);
  }
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw UsageError("'" + reference + "' is not in the store", "see phiz store ls " + record.name);
  throw UsageError("several stages have an output '" + output + "'", "use SUBJECT/STAGE/OUTPUT");
}

}  // namespace phiz
