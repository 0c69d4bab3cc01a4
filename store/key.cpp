#include "store/key.h"

#include <algorithm>
#include <charconv>

#include "store/error.h"

namespace phiz {
namespace {

constexpr std::string_view kHeader = "phiz-key 1\n";

bool is_word(std::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
  });
}

/// Cuts the text up to the next space; nothing if there is none.
std::optional<std::string_view> take_word(std::string_view& text) {
  const std::size_t end = text.find(' ');
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(end + 1);
  return word;
}

std::optional<std::string> find_value(const KeyText& text, const KeyText::Entry& like) {
  for (const KeyText::Entry& entry : text.entries()) {
    if (entry.tag == like.tag && entry.name == like.name) return entry.value;
  }
  return std::nullopt;
}

}  // namespace

void KeyText::add(std::string_view tag, std::string_view name, std::string_view value) {
  if (!is_word(tag) || !is_word(name)) {
    throw StoreError(StoreFault::kInvalidName,
                     "not a name for a key: " + std::string(tag) + " " + std::string(name));
  }
  entries_.push_back({std::string(tag), std::string(name), std::string(value)});
}

std::string KeyText::text() const {
  std::string text(kHeader);
  for (const Entry& entry : entries_) {
    text +=
        entry.tag + " " + entry.name + " " + std::to_string(entry.value.size()) + " " + entry.value + "\n";
  }
  return text;
}

std::optional<KeyText> parse_key_text(std::string_view text) {
  if (!text.starts_with(kHeader)) return std::nullopt;
  text.remove_prefix(kHeader.size());
  KeyText parsed;
  while (!text.empty()) {
    const auto tag = take_word(text), name = take_word(text), length = take_word(text);
    if (!tag || !name || !length || !is_word(*tag) || !is_word(*name)) return std::nullopt;
    std::size_t size = 0;
    const auto [end, error] = std::from_chars(length->data(), length->data() + length->size(), size);
    if (error != std::errc() || end != length->data() + length->size()) return std::nullopt;
    if (size >= text.size() || text[size] != '\n') return std::nullopt;
    parsed.add(*tag, *name, text.substr(0, size));
    text.remove_prefix(size + 1);
  }
  return parsed;
}

std::vector<KeyDifference> compare_keys(const KeyText& before, const KeyText& after) {
  std::vector<KeyDifference> differences;
  for (const KeyText::Entry& entry : after.entries()) {
    const auto old_value = find_value(before, entry);
    if (old_value != entry.value) differences.push_back({entry.tag, entry.name, old_value, entry.value});
  }
  for (const KeyText::Entry& entry : before.entries()) {
    if (!find_value(after, entry)) differences.push_back({entry.tag, entry.name, entry.value, std::nullopt});
  }
  return differences;
}

}  // namespace phiz
