/// Private to the writers of web pages and XML: text that is safe inside HTML, SVG and XML.
#pragma once

#include <string>
#include <string_view>

#include "gradus/io/image.hpp"

namespace gradus::markup {

/// Text as content or attribute value: & < > " ' become entities, control characters other than tab and line end are
/// dropped.
std::string escape(std::string_view text);

/// #rrggbb
std::string colour(const Colour& colour);

std::string base64(std::string_view bytes);

}  // namespace gradus::markup
