#include "gradus/remesh/delaunay.hpp"

#include <catch2/catch.hpp>
