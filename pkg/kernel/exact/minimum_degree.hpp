// Fill-reducing elimination order of a symmetric pattern.
#pragma once

#include <cstdint>
#include <vector>

namespace rcr {

/// Order in which to eliminate the nodes of a graph, by approximate minimum degree.
///
/// The neighbours of node i are neighbours[begin[i]] … neighbours[begin[i + 1] − 1], each edge listed at both ends,
/// without loops or repetitions. Of two nodes of one degree the one reached last goes first, so the order is a function
/// of the input alone.
/// Source: Amestoy, Davis and Duff 1996 (quotient graph, approximate degrees, element absorption).
std::vector<std::int32_t> minimumDegreeOrder(const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& neighbours);

} // namespace rcr
