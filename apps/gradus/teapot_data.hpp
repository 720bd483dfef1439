/// The teapot, inside the program: an installed one needs no file.
#pragma once

namespace gradus::app {

extern const char* const kTeapot;  ///< text of assets/teapot.bpt

}  // namespace gradus::app
