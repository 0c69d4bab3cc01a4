#include <istream>
#include <streambuf>

#include "formats/error.h"
#include "formats/readers/cloud_builder.h"
#include "formats/readers/readers.h"

namespace phiz::readers {
namespace {

/// A stream over bytes in memory that can be positioned anywhere in them.
class SpanBuffer : public std::streambuf {
 public:
  explicit SpanBuffer(std::span<const std::byte> bytes) {
    char* first =
        const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));  // never written: no overflow()
    setg(first, first, first + bytes.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode which) override {
    if (!(which & std::ios_base::in)) return pos_type(off_type(-1));
    if (from == std::ios_base::cur) offset += gptr() - eback();
    if (from == std::ios_base::end) offset += egptr() - eback();
    if (offset < 0 || offset > egptr() - eback()) return pos_type(off_type(-1));
    setg(eback(), eback() + offset, egptr());
    return pos_type(offset);
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode which) override {
    return seekoff(off_type(position), std::ios_base::beg, which);
  }
};

}  // namespace

ScanFile read_vdb(std::span<const std::byte> bytes, const ScanLimits& limits) {
  SpanBuffer buffer(bytes);
  std::istream stream(&buffer);
  ScanFile scan;
  scan.points = read_vdb_points(stream);
  CloudBuilder::check_count(scan.points.size(), limits);
  if (scan.points.size() == 0) throw FormatError("holds no points", "was the right object exported?");
  scan.format = "vdb";
  return scan;
}

}  // namespace phiz::readers
