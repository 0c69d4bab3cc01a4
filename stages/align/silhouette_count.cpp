#include <bit>

#include "stages/align/silhouette.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

// The same loop compiled twice: with the processor's bit count, and without for those that lack it.
template <class Word>
[[gnu::always_inline]] inline std::int64_t sum_bits(std::size_t count, const Word& word) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += std::popcount(word(i));
  return sum;
}

struct Words {
  const std::uint64_t *a, *b, *mask;
  std::size_t count;
};

[[gnu::always_inline]] inline std::int64_t count_words(const Words& w) {
  if (w.mask) return sum_bits(w.count, [&](std::size_t i) { return (w.a[i] ^ w.b[i]) & w.mask[i]; });
  if (w.b) return sum_bits(w.count, [&](std::size_t i) { return w.a[i] ^ w.b[i]; });
  return sum_bits(w.count, [&](std::size_t i) { return w.a[i]; });
}

std::int64_t count_plain(const Words& words) {
  return count_words(words);
}

#if defined(__x86_64__) && defined(__GNUC__)
[[gnu::target("popcnt")]] std::int64_t count_fast(const Words& words) {
  return count_words(words);
}

std::int64_t count(const Words& words) {
  static const bool has_popcnt = __builtin_cpu_supports("popcnt");
  return has_popcnt ? count_fast(words) : count_plain(words);
}
#else
std::int64_t count(const Words& words) {
  return count_plain(words);
}
#endif

bool same_size(const Silhouette& a, const Silhouette& b) {
  return a.width() == b.width() && a.height() == b.height();
}

}  // namespace

std::int64_t count_pixels(const Silhouette& a) {
  return count({a.words().data(), nullptr, nullptr, a.words().size()});
}

std::int64_t count_xor(const Silhouette& a, const Silhouette& b) {
  CONTRACT(same_size(a, b));
  return count({a.words().data(), b.words().data(), nullptr, a.words().size()});
}

std::int64_t count_xor(const Silhouette& a, const Silhouette& b, const Silhouette& mask) {
  CONTRACT(same_size(a, b) && same_size(a, mask));
  return count({a.words().data(), b.words().data(), mask.words().data(), a.words().size()});
}

}  // namespace phiz
