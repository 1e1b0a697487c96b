#pragma once
// The subdivisions that the adaptive subdivision is compared with: the general and the intermediate patterns of Nakao
// et al. 2006 (doi 10.1007/s10916-006-9021-4), Table 1. The table gives the average increase of elements: 16 with 1
// pattern, 8.6 with 5, 5.6 with 11, and 4.8 with the adaptive 2. The paper gives only the numbers of patterns; the
// definitions below are ours. No vertex is moved onto the blade: every crossed element is divided, points on crossed
// edges lie where the blade crosses the edges, and the section consists of faces on the blade that both sides share.
// Units mm.
//
// general, 1 pattern, 1:17. Each of the 6 edges gets a point (where the blade crosses the edge, else the midpoint), and
// each of the 4 faces gets a point (the middle of the section's chord, else the centroid). Each edge a-b with its point
// m and the points f, g of its two faces gives the elements (a, m, f, g) and (m, b, f, g): 12 in all. Each corner with
// the points of its three faces gives an element: 4 in all. The four face points give 1 element. A triangle section
// round corner a consists of the three faces (m, f, g) of the crossed edges and of the face (f, g, h) between the
// corner's element and the middle element:
//
//        a            seen along the blade: m f m f m f in a ring, f g h in its middle
//       /|\           above: the corner's element and one half of each crossed edge
//      m-f-m          below: the rest
//     /  |  \         .
//
// With a quadrilateral section (a, b above, c, d below) the four face points are the middles of the quadrilateral's
// sides. They form a parallelogram (Varignon's theorem), so that the middle element is flat and is left out. Without
// the middle element the two sides see different diagonals of the parallelogram: elements above see the diagonal that
// joins the points of the faces abc and abd, and elements below see the other diagonal. The shorter diagonal is kept.
// On the other side the four elements round the longer diagonal (two corners, two halves of the uncrossed edge) are
// replaced by six elements round the uncrossed edge's point, which gives 18 elements. Where the blade runs through one
// corner of the element, the pattern is that of a triangle section; the last paragraph describes a blade through two
// corners.
//
// intermediate, 11 patterns. Each crossed edge is bisected where the blade crosses it, and the set of edges with a
// point decides the division of an element. There are exactly 11 graphs on four vertices up to renaming. This is the
// adaptive bisection without moving vertices onto the blade.
//
// intermediate, 5 patterns, red and green (Bey 1995, doi 10.1007/BF02238487). Crossed elements are red, 1:8: all edges
// get points, four corners are cut off, and the octahedron between the corners is divided in four round a diagonal.
// With a triangle section the corner's face is the section. With a quadrilateral section the diagonal lies in the
// section, and the four points of crossed edges with that diagonal form two faces on the blade. The shortest allowed
// diagonal is taken. Neighbours are green: a point on 1 edge (2 elements), on 2 edges of a face (3), on 2 opposite
// edges (4), on the 3 edges of a face (4). A neighbour with any other set of points becomes red too, which is repeated
// until no such neighbour is left, at the latest when every element is red.
//
// Neighbours of 1:17 elements are closed by pulling. Every face is fanned from its least point (points on faces first,
// then points on edges, then corners; by id), and the element is coned from its least point. The division of a face
// depends on the face alone, so that both its elements agree.
//
// Where the blade runs through corners of a crossed element in another way (through two corners; for red elements
// through any corner), no pattern puts the section on faces. Such elements are closed like neighbours, and edges that
// the blade still crosses are bisected. The same is done for 1:17 where a blade twists so much within an element that
// parts of the element would be turned over.

#include "mesh/cutting/store/cut_types.h"
#include "mesh/cutting/stroke/cut_moves.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// True for subdivisions that do more than bisect crossed edges.
constexpr bool has_own_patterns(Subdivision subdivision)
{
    return subdivision == Subdivision::general || subdivision == Subdivision::intermediate_5;
}

/// Divides the crossed elements of a stroke and closes their neighbours. New vertices on the blade are marked as on the
/// blade.
/// @pre has_own_patterns(options.subdivision); the elements are living and crossed
void divide_by_pattern(StrokeState& stroke, std::span<const TetId> crossed);

/// The elements that a blade crosses before any vertex is moved, ascending. The increase of elements is relative to
/// their number.
std::vector<TetId> crossed_elements(const TetMesh& mesh, const SweptBlade& blade);

} // namespace retractor::mesh
