// Letters as strokes on a grid of 8 x 9, rounded by cutting corners, set on whole pixels.
// SPDX-License-Identifier: MIT
// Source: Chaikin, "An Algorithm for High-Speed Curve Generation", 1974 (cutting corners).
//
// A letter is a list of strokes; a stroke is a list of points, two digits each: x 0..8 from left to right, y 0..9 from
// the lowest descender; letters stand on 2, small ones reach 7, capitals 9. `~` before a stroke: its corners are
// rounded; `o` behind it: it is closed. A stroke of one point twice is a dot.
#include "tool/play/picture/font.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ticktrue::play {
namespace {

constexpr std::array<std::string_view, 95> strokes{
    "",                          // space
    "4945 4242",                 // !
    "2927 6967",                 // "
    "2228 6268 0484 0676",       // #
    "~8889090686820203 4149",    // $
    "0289 1818 7373",            // %
    "~822739595704025285",       // &
    "4947",                      // '
    "~69474361",                 // (
    "~29474321",                 // )
    "4347 1674 1476",            // *
    "1575 4347",                 // +
    "4230",                      // ,
    "1575",                      // -
    "4242",                      // .
    "0189",                      // /
    "~09898202o 3556",           // 0
    "174942 1272",               // 1
    "~08098986 860282",          // 2
    "~09898636 ~36868202",       // 3
    "62690484",                  // 4
    "890906 ~06868202",          // 5
    "~790902828606",             // 6
    "098932",                    // 7
    "~19797616o ~06868202o",     // 8
    "~128289090585",             // 9
    "4343 4747",                 // :
    "4747 4230",                 // ;
    "781572",                    // <
    "1474 1676",                 // =
    "187512",                    // >
    "~08098986 ~864644 4242",    // ?
    "~8202098984545787",         // @
    "024982 1474",               // A
    "0209 ~09797606 ~06868202",  // B
    "~888909028283",             // C
    "0209 ~09898202",            // D
    "89090282 0666",             // E
    "890902 0666",               // F
    "~888909028285 4585",        // G
    "0209 8289 0686",            // H
    "2969 4942 2262",            // I
    "~79720204",                 // J
    "0209 8905 2682",            // K
    "090282",                    // L
    "0209458982",                // M
    "02098289",                  // N
    "~09898202o",                // O
    "0209 ~09898505",            // P
    "~09898202o 5481",           // Q
    "0209 ~09898505 4582",       // R
    "~8889090686820203",         // S
    "0989 4942",                 // T
    "~09028289",                 // U
    "094289",                    // V
    "0922476289",                // W
    "0289 0982",                 // X
    "094589 4542",               // Y
    "09890282",                  // Z
    "69393161",                  // [
    "0981",                      // backslash
    "29595121",                  // ]
    "164976",                    // ^
    "0181",                      // _
    "3948",                      // `
    "~178782 ~85050282",         // a
    "0902 ~07878202",            // b
    "~87070282",                 // c
    "8982 ~87070282",            // d
    "0585 ~8587070282",          // e
    "~793932 0777",              // f
    "~87070282 ~878010",         // g
    "0902 ~078782",              // h
    "274742 2262 4949",          // i
    "2767 ~676000 6969",         // j
    "0902 7704 3582",            // k
    "294942 2262",               // l
    "0702 ~074742 ~478782",      // m
    "0702 ~078782",              // n
    "~07878202o",                // o
    "0700 ~07878202",            // p
    "8780 ~87070282",            // q
    "0702 ~040777",              // r
    "~870705858202",             // s
    "~393272 0777",              // t
    "~070282 8782",              // u
    "074287",                    // v
    "0722466287",                // w
    "0782 0287",                 // x
    "~070282 ~878010",           // y
    "07870282",                  // z
    "~69494625444161",           // {
    "4149",                      // |
    "~29494665444121",           // }
    "~05274476",                 // tilde
};

using Stroke = std::vector<Pixel>;

Stroke cut_corners(const Stroke& points, bool closed) {
  Stroke cut;
  if (!closed) cut.push_back(points.front());
  const std::size_t count = closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Pixel& a = points[i];
    const Pixel& b = points[(i + 1) % points.size()];
    cut.push_back({a.x * 0.75 + b.x * 0.25, a.y * 0.75 + b.y * 0.25});
    cut.push_back({a.x * 0.25 + b.x * 0.75, a.y * 0.25 + b.y * 0.75});
  }
  if (!closed) cut.push_back(points.back());
  return cut;
}

double distance_to(const Pixel& p, const Pixel& a, const Pixel& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double square = dx * dx + dy * dy;
  const double share = square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - share * dx, p.y - a.y - share * dy);
}

/// Grid lines on the middles of pixels, so that straight strokes are sharp.
struct Grid {
  double unit;      // px
  int margin;       // px around the letter
  int letter_rows;  // px from the middle of the lowest line to that of the highest
  Pixel place(char x, char y) const {
    return {margin + std::round((x - '0') * unit / 2) + 0.5, margin + letter_rows - std::round((y - '0') * unit) + 0.5};
  }
};

std::vector<Stroke> strokes_of(std::string_view text, const Grid& grid) {
  std::vector<Stroke> list;
  while (!text.empty()) {
    std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    const bool smooth = word.front() == '~';
    const bool closed = word.back() == 'o';
    if (smooth) word.remove_prefix(1);
    if (closed) word.remove_suffix(1);
    Stroke stroke;
    for (std::size_t i = 0; i + 1 < word.size(); i += 2) stroke.push_back(grid.place(word[i], word[i + 1]));
    for (int i = 0; smooth && i < 3; ++i) stroke = cut_corners(stroke, closed);
    if (closed) stroke.push_back(stroke.front());
    list.push_back(std::move(stroke));
  }
  return list;
}

}  // namespace

Font::Font(double size_px) {
  const double unit = size_px / 7;
  const double half_width = std::max(0.6, 0.5 * unit);  // of a stroke, px
  const Grid grid{unit, 2, static_cast<int>(std::round(9 * unit))};
  const int letter_width = static_cast<int>(std::round(4 * unit)) + 1;
  advance_ = letter_width + std::max(2, static_cast<int>(std::round(1.6 * unit)));
  line_ = static_cast<int>(std::round(12.5 * unit));
  above_ = grid.margin - static_cast<int>(std::round(1.5 * unit));
  for (std::size_t letter = 0; letter < letters_.size(); ++letter) {
    Mask& mask = letters_[letter];
    mask.width = letter_width + 2 * grid.margin;
    mask.height = grid.letter_rows + 1 + 2 * grid.margin;
    const int pixel_count = mask.width * mask.height;
    mask.coverage.assign(static_cast<std::size_t>(pixel_count), 0);
    const std::vector<Stroke> list = strokes_of(strokes[letter], grid);
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        double nearest = 1e9;
        for (const Stroke& stroke : list)
          for (std::size_t i = 0; i + 1 < stroke.size(); ++i)
            nearest = std::min(nearest, distance_to({x + 0.5, y + 0.5}, stroke[i], stroke[i + 1]));
        const int pixel = y * mask.width + x;
        mask.coverage[static_cast<std::size_t>(pixel)] =
            static_cast<std::uint8_t>(255 * std::clamp(half_width + 0.5 - nearest, 0.0, 1.0));
      }
  }
}

void Font::draw(Canvas& canvas, int x, int y, std::string_view text, Color color) const {
  for (const char letter : text) {
    const std::size_t index = letter >= ' ' && letter <= '~' ? static_cast<std::size_t>(letter - ' ') : '?' - ' ';
    canvas.mask(letters_[index], x - 2, y - above_, color);
    x += advance_;
  }
}

}  // namespace ticktrue::play
