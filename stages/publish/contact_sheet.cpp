#include <algorithm>

#include "stages/publish/bitmap_font.h"
#include "stages/publish/views.h"

namespace phiz {
namespace {

constexpr int kGap = 8, kScale = 2, kLine = kGlyphHeight * kScale + 10;
constexpr std::array<std::uint8_t, 3> kPaper = {255, 255, 255};

void paste(Image& sheet, const Image& picture, int left, int top) {
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) sheet.at(left + x, top + y) = picture.at(x, y);
}

struct Grid {
  std::vector<int> column_widths, row_heights;
  int width = kGap, height = kGap;
};

Grid measure(const std::vector<std::vector<Image>>& rows,
             const std::vector<std::vector<std::string>>& labels) {
  Grid grid;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    int height = 0;
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      if (c == grid.column_widths.size()) grid.column_widths.push_back(0);
      int needed = rows[r][c].width;
      if (r < labels.size() && c < labels[r].size())
        needed = std::max(needed, compute_text_width(labels[r][c], kScale));
      grid.column_widths[c] = std::max(grid.column_widths[c], needed);
      height = std::max(height, rows[r][c].height);
    }
    const bool labelled = r < labels.size() && !labels[r].empty();
    grid.row_heights.push_back(height + (labelled ? kLine : 0));
    grid.height += grid.row_heights.back() + kGap;
  }
  for (const int width : grid.column_widths) grid.width += width + kGap;
  return grid;
}

}  // namespace

Image contact_sheet(const std::vector<std::vector<Image>>& rows,
                    const std::vector<std::vector<std::string>>& labels, const std::string& title) {
  const Grid grid = measure(rows, labels);
  Image sheet;
  sheet.width = std::max(grid.width, title.empty() ? 0 : compute_text_width(title, kScale) + 2 * kGap);
  sheet.height = grid.height + (title.empty() ? 0 : kLine);
  sheet.pixels.assign(static_cast<std::size_t>(sheet.width) * sheet.height, kPaper);
  int top = kGap;
  if (!title.empty()) {
    draw_text(sheet, kGap, kGap, title, {});
    top += kLine;
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    int left = kGap;
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      const Image& picture = rows[r][c];
      paste(sheet, picture, left + (grid.column_widths[c] - picture.width) / 2, top);
      if (r < labels.size() && c < labels[r].size()) {
        const int width = compute_text_width(labels[r][c], kScale);
        draw_text(sheet, left + (grid.column_widths[c] - width) / 2, top + picture.height + 5, labels[r][c],
                  {});
      }
      left += grid.column_widths[c] + kGap;
    }
    top += grid.row_heights[r] + kGap;
  }
  return sheet;
}

}  // namespace phiz
