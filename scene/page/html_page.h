// What the program's HTML pages share: one style, escapes, pictures inside the page. A page needs no other file.
#pragma once

#include <string>

#include "sensor/picture/raster.h"

namespace obscura::detail {

std::string html_escaped(const std::string& text);

/// The picture as an <img> that holds its own PNG.
std::string html_picture(const std::string& title, const Raster& picture);

/// A whole page around a body. @param title,body title is escaped here, the body is HTML
std::string html_page(const std::string& title, const std::string& body);

}  // namespace obscura::detail
