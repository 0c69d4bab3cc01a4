#include "store/store.h"

#include <algorithm>

#include "store/error.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

constexpr std::uint64_t kMaxJsonBytes = 16 << 20;

std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text));
}

/// True if the file holds exactly `bytes`.
bool holds(FileSystem& files, const std::filesystem::path& path, std::span<const std::byte> bytes) {
  bool equal = true;
  files.read_blocks(path, [&](std::span<const std::byte> block) {
    equal = equal && block.size() <= bytes.size() && std::equal(block.begin(), block.end(), bytes.begin());
    bytes = bytes.subspan(std::min(block.size(), bytes.size()));
  });
  return equal && bytes.empty();
}

/// Where the record names the result as current, it gets its note.
void note_result(const Result& result, SubjectRecord& record) {
  ResultNote note = make_note(result);
  const std::string stage = result.stage();
  const auto current = record.results.find(stage);
  if (current != record.results.end() && current->second == note.key) record.notes[stage] = std::move(note);
}

std::optional<std::string> stem_of_json(const std::string& name) {
  if (is_temporary_name(name) || !name.ends_with(".json")) return std::nullopt;
  return name.substr(0, name.size() - 5);
}

}  // namespace

bool StoreNames::has(const ResultNote& note) const {
  return std::binary_search(results.begin(), results.end(), note.key) &&
         std::all_of(note.outputs.begin(), note.outputs.end(), [&](const auto& output) {
           return std::binary_search(objects.begin(), objects.end(), output.second.digest);
         });
}

std::optional<std::uint64_t> Store::find_object_size(const Digest& digest) const {
  const auto status = files_->find_status(layout_.object(digest));
  if (!status || status->kind != FileSystem::Kind::kFile) return std::nullopt;
  return status->size_bytes;
}

std::string Store::read_object(const Digest& digest) const {
  const std::filesystem::path path = layout_.object(digest);
  std::string bytes = files_->read_file(path);
  if (compute_digest(bytes) == digest) return bytes;
  const std::filesystem::path aside = set_aside(path);
  throw StoreError(
      StoreFault::kDamaged,
      "object " + digest.hex() + ": its bytes are not what was written; set aside as " + aside.string(),
      "run the same command again: what is missing is computed anew");
}

OutputObject Store::put_object(DurableWriter& writer, std::string_view bytes) const {
  const OutputObject object{compute_digest(bytes), bytes.size()};
  const std::filesystem::path path = layout_.object(object.digest);
  if (files_->find_status(path)) {
    if (holds(*files_, path, as_bytes(bytes))) return object;
    set_aside(path);
  }
  writer.make_folder(layout_.object_folder(object.digest));
  writer.add(path, as_bytes(bytes), FileSystem::Mode::kReadOnly);
  return object;
}

std::vector<Digest> Store::list_objects() const {
  std::vector<Digest> digests;
  for (const std::string& folder : files_->list_folder(layout_.objects())) {
    if (folder.size() != 2) continue;
    for (const std::string& name : files_->list_folder(layout_.objects() / folder)) {
      if (const auto digest = parse_digest(folder + name)) digests.push_back(*digest);
    }
  }
  return digests;
}

std::optional<Result> Store::find_result(const Digest& key) const {
  const std::filesystem::path path = layout_.result(key);
  try {
    Result result = parse_result(files_->read_file(path, kMaxJsonBytes), path.string());
    if (result.key() == key) return result;
  } catch (const StoreError& error) {
    if (error.fault() == StoreFault::kMissing) return std::nullopt;
    if (error.fault() != StoreFault::kDamaged) throw;
  }
  set_aside(path);
  return std::nullopt;
}

bool Store::has(const ResultNote& note, Care care) const {
  const std::filesystem::path path = layout_.result(note.key);
  if (care == Care::kLook) {
    if (!files_->find_status(path)) return false;
  } else {
    try {
      const std::string text = files_->read_file(path, kMaxJsonBytes);
      if (read_seal(text) != note.seal || !is_sealed_well(text)) return false;
    } catch (const StoreError& error) {
      if (error.fault() == StoreFault::kMissing) return false;
      throw;
    }
  }
  return std::all_of(note.outputs.begin(), note.outputs.end(), [&](const auto& output) {
    return find_object_size(output.second.digest) == output.second.size_bytes;
  });
}

std::vector<std::string> Store::list_missing_outputs(const Result& result) const {
  std::vector<std::string> missing;
  for (const auto& [name, output] : result.outputs) {
    if (find_object_size(output.digest) != output.size_bytes) missing.push_back(name);
  }
  return missing;
}

std::optional<Result> Store::find_done_result(const Digest& key) const {
  auto result = find_result(key);
  if (result && list_missing_outputs(*result).empty()) return result;
  return std::nullopt;
}

/// What was there already when we looked may have been collected as nobody's before our result named it.
void Store::put_back_removed(const CommitRequest& request, const Result& result) const {
  DurableWriter writer(*files_);
  for (const auto& [name, bytes] : request.outputs) {
    const auto output = result.outputs.find(name);
    const bool is_ours = output != result.outputs.end() && output->second.size_bytes == bytes.size();
    if (is_ours && !find_object_size(output->second.digest)) put_object(writer, bytes);
  }
  for (const std::string_view bytes : request.inputs_to_keep) {
    if (!find_object_size(compute_digest(bytes))) put_object(writer, bytes);
  }
  const std::filesystem::path file = layout_.result(result.key());
  const bool is_gone = !files_->find_status(file);
  const std::string text = is_gone ? format_result(result) : "";
  if (is_gone) writer.add(file, as_bytes(text), FileSystem::Mode::kWritable);
  writer.publish();
}

CommitOutcome Store::commit(CommitRequest request) const {
  CommitOutcome outcome{std::move(request.result), false};
  outcome.result.outputs.clear();
  DurableWriter objects(*files_);
  for (const auto& [name, bytes] : request.outputs) outcome.result.outputs[name] = put_object(objects, bytes);
  for (const std::string_view bytes : request.inputs_to_keep) put_object(objects, bytes);
  objects.publish();

  DurableWriter records(*files_);
  const Digest key = outcome.result.key();
  if (auto existing = find_done_result(key)) {
    outcome.differed = existing->outputs != outcome.result.outputs;
    outcome.result = std::move(*existing);
  } else {
    const std::string text = format_result(outcome.result);
    outcome.result.seal = read_seal(text).value();
    records.add(layout_.result(key), as_bytes(text), FileSystem::Mode::kWritable);
  }
  if (request.subject) note_result(outcome.result, *request.subject);
  if (request.subject) add_subject(records, *request.subject);
  records.publish();
  put_back_removed(request, outcome.result);
  return outcome;
}

void Store::put_result(const Result& result) const {
  if (find_done_result(result.key())) return;
  const std::string text = format_result(result);
  DurableWriter writer(*files_);
  writer.add(layout_.result(result.key()), as_bytes(text), FileSystem::Mode::kWritable);
  writer.publish();
}

std::vector<Digest> Store::list_results() const {
  std::vector<Digest> keys;
  for (const std::string& name : files_->list_folder(layout_.results())) {
    const auto stem = stem_of_json(name);
    if (!stem) continue;
    if (const auto key = parse_digest(*stem)) keys.push_back(*key);
  }
  return keys;
}

void Store::pin(const Digest& key) const {
  files_->make_folders(layout_.pins());
  if (files_->create_exclusively(layout_.pins() / key.hex(), {})) files_->sync_folder(layout_.pins());
}

bool Store::unpin(const Digest& key) const {
  return files_->remove_file(layout_.pins() / key.hex());
}

std::vector<Digest> Store::list_pins() const {
  std::vector<Digest> keys;
  if (!files_->find_status(layout_.pins())) return keys;
  for (const std::string& name : files_->list_folder(layout_.pins())) {
    if (const auto key = parse_digest(name)) keys.push_back(*key);
  }
  return keys;
}

std::optional<SubjectRecord> Store::find_subject(const std::string& name) const {
  validate_subject_name(name);
  const std::filesystem::path path = layout_.subject(name);
  try {
    return parse_subject(files_->read_file(path, kMaxJsonBytes), path.string());
  } catch (const StoreError& error) {
    if (error.fault() == StoreFault::kMissing) return std::nullopt;
    throw;
  }
}

void Store::add_subject(DurableWriter& writer, const SubjectRecord& record) const {
  validate_subject_name(record.name);
  const std::filesystem::path path = layout_.subject(record.name);
  const std::string text = format_subject(record);
  if (files_->find_status(path) && holds(*files_, path, as_bytes(text))) return;
  writer.add(path, as_bytes(text), FileSystem::Mode::kWritable);
}

void Store::save_subject(const SubjectRecord& record) const {
  DurableWriter writer(*files_);
  add_subject(writer, record);
  writer.publish();
}

std::vector<std::string> Store::list_subjects() const {
  std::vector<std::string> names;
  for (const std::string& name : files_->list_folder(layout_.subjects())) {
    if (auto stem = stem_of_json(name)) names.push_back(std::move(*stem));
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::filesystem::path Store::set_aside(const std::filesystem::path& file) const {
  files_->make_folders(layout_.damaged());
  const std::string folder = file.parent_path().filename().string();
  const std::filesystem::path aside =
      layout_.damaged() / (folder + "-" + file.filename().string() + "." + make_unique_name());
  try {
    files_->rename(file, aside);
  } catch (const StoreError& error) {
    if (error.fault() != StoreFault::kMissing) throw;  // somebody else has set it aside already
  }
  return aside;
}

}  // namespace phiz
