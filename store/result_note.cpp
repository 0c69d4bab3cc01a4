#include "store/result_note.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

namespace phiz {
namespace {

bool is_word(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](char c) { return c > ' ' && c <= '~' && c != '"' && c != '\\'; });
}

bool can_be_written(const std::string& stage, const ResultNote& note) {
  const auto has_word = [](const auto& entry) { return is_word(entry.first); };
  return is_word(stage) && std::all_of(note.inputs.begin(), note.inputs.end(), has_word) &&
         std::all_of(note.outputs.begin(), note.outputs.end(), has_word);
}

template <class Number>
std::string format_number(Number value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

template <class Number>
bool read_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool read_digest(std::string_view text, Digest& digest) {
  const auto parsed = parse_digest(text);
  if (parsed) digest = *parsed;
  return parsed.has_value();
}

std::string_view take_until(std::string_view& text, char end) {
  const std::size_t length = std::min(text.find(end), text.size());
  const std::string_view taken = text.substr(0, length);
  text.remove_prefix(std::min(length + 1, text.size()));
  return taken;
}

/// One line into the notes; `current` is the note that inputs and outputs belong to. False if it is not one.
bool read_line(std::string_view line, std::map<std::string, ResultNote>& notes, ResultNote*& current) {
  const std::string_view kind = take_until(line, ' ');
  const std::string name(take_until(line, ' '));
  if (!is_word(name)) return false;
  if (kind == "result") {
    current = &notes[name];
    return read_digest(take_until(line, ' '), current->key) &&
           read_digest(take_until(line, ' '), current->seal) && read_number(line, current->seconds);
  }
  if (current == nullptr) return false;
  if (kind == "input") return read_digest(line, current->inputs[name]);
  if (kind != "output") return false;
  OutputObject& output = current->outputs[name];
  return read_digest(take_until(line, ' '), output.digest) && read_number(line, output.size_bytes);
}

}  // namespace

ResultNote make_note(const Result& result) {
  ResultNote note{result.key(), result.seal, result.run.seconds, {}, result.outputs};
  for (const KeyText::Entry& entry : result.key_text.entries()) {
    if (entry.tag != "input") continue;
    if (const auto digest = parse_digest(entry.value)) note.inputs[entry.name] = *digest;
  }
  return note;
}

std::string format_notes(const std::map<std::string, ResultNote>& notes) {
  std::string text;
  for (const auto& [stage, note] : notes) {
    if (!can_be_written(stage, note)) continue;
    text += "result " + stage + " " + note.key.hex() + " " + note.seal.hex() + " " +
            format_number(note.seconds) + "\n";
    for (const auto& [name, digest] : note.inputs) text += "input " + name + " " + digest.hex() + "\n";
    for (const auto& [name, output] : note.outputs) {
      text += "output " + name + " " + output.digest.hex() + " " + format_number(output.size_bytes) + "\n";
    }
  }
  return text;
}

std::map<std::string, ResultNote> parse_notes(std::string_view text) {
  std::map<std::string, ResultNote> notes;
  ResultNote* current = nullptr;
  while (!text.empty()) {
    if (!read_line(take_until(text, '\n'), notes, current)) return {};
  }
  return notes;
}

}  // namespace phiz
