#include "scene/page/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sensor/picture/image_io.h"

namespace obscura::detail {
namespace {

const char* const kStyle = R"(
:root { color-scheme: light dark; --ink: #1c1d22; --paper: #fbfbfc; --faint: #6b6d78; --line: #d9dae0; --good: #1a7f37; --bad: #c62828; --card: #12131808; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e4ea; --paper: #16171c; --faint: #9a9ca8; --line: #34363f; --good: #56d364; --bad: #ff7b72; --card: #ffffff08; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 1180px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.5rem; border-top: 1px solid var(--line); padding-top: 1rem; }
p.about, td.faint, .what { color: var(--faint); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 13px; }
th, td { padding: 2px 10px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; }
.agree { color: var(--good); } .differ { color: var(--bad); font-weight: 600; }
.pictures { display: flex; flex-wrap: wrap; gap: 8px; margin: 8px 0; }
.pictures img { image-rendering: pixelated; display: block; max-width: 100%; }
svg { max-width: 100%; height: auto; }
.plots { display: flex; flex-wrap: wrap; gap: 20px; margin-top: 20px; }
code { font-size: 12px; overflow-wrap: anywhere; } details { margin: 4px 0; } summary { cursor: pointer; }
td.words { white-space: normal; text-align: left; min-width: 16rem; }
figure { margin: 0; } figcaption { color: var(--faint); font-size: 13px; }
)";

/// RFC 4648.
std::string base64(const std::vector<std::uint8_t>& bytes) {
  static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? letters[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string html_picture(const std::string& title, const Raster& picture) {
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n", html_escaped(title),
                     base64(png_bytes(picture)));
}

std::string html_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, "
      "initial-scale=1\">\n<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      html_escaped(title), kStyle, body);
}

}  // namespace obscura::detail
