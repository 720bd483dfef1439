/// Files of cages for subdivision.
#pragma once

#include <string>

#include "gradus/io/error.hpp"
#include "gradus/surface/subdivision.hpp"

namespace gradus {

/// A Wavefront `.obj` of polygons, with the tags of OpenSubdiv's shapes in lines `t`: crease, corner, hole,
/// interpolateboundary, creasemethod, smoothtriangles; those of face-varying data say nothing of the shape. The labels
/// of faces are the materials (`usemtl`), or the groups (`g`) where there are none, numbered from 1 as they come; no
/// labels if all are the same.
/// @throws IoError with path and line if the file cannot be read or is malformed, or for a tag of another kind
Cage read_cage(const std::string& path);

}  // namespace gradus
