#pragma once
// What the adaptive subdivision is compared with: the general and the intermediate patterns of the source's Table 1
// (Nakao et al., "hybrid virtual body", seed A3: increase of elements 16 with 1 pattern, 8.6 with 5, 5.6 with 11, 4.8
// with the adaptive 2). The source names their numbers only; the definitions are ours. In all of them nothing is
// snapped: every crossed element is divided, points on crossed edges lie where the blade crosses them, and the section
// comes out as faces on the blade that both sides share. Units mm.
//
// general, 1 pattern, 1:17. A point on each of the 6 edges (where the blade crosses, else the midpoint) and on each of
// the 4 faces (the middle of the section's chord, else the centroid). Each edge a-b with its point m and the points f,
// g of its two faces gives (a, m, f, g) and (m, b, f, g): 12. Each corner with the points of its three faces: 4. The
// four face points: 1. With a triangle section, round corner a, the blade is made of the three (m, f, g) of the crossed
// edges and the (f, g, h) that parts the corner's element from the middle one:
//
//        a            seen along the blade: m f m f m f in a ring, f g h in its middle
//       /|\           above: the corner's element and one half of each crossed edge
//      m-f-m          below: the rest
//     /  |  \         .
//
// With a quadrilateral section (a, b above, c, d below) the four face points are the middles of the quadrilateral's
// sides: they form a parallelogram (Varignon), so the middle element is flat. It is left out, and then the two sides
// see different diagonals of the parallelogram: those above the one that joins the points of the faces abc and abd,
// those below the other. The shorter one is kept; on the other side the four elements round the longer one (two
// corners, two halves of the uncrossed edge) are replaced by six round the uncrossed edge's point: 18 elements. Where
// the blade runs through one corner of the element the pattern is that of a triangle section; where it runs through
// two, see below.
//
// intermediate, 11 patterns. Each crossed edge is bisected where the blade crosses it, and an element is divided by
// which of its edges carry a point. Graphs on four vertices, up to renaming, are exactly 11. This is the adaptive
// bisection without snapping.
//
// intermediate, 5 patterns, red and green (Bey 1995, doi 10.1007/BF02238487). Crossed elements are red, 1:8: points on
// all edges, four corners, and the octahedron left between them in four round a diagonal. With a triangle section the
// corner's face is the section; with a quadrilateral one the diagonal lies in it, and the four points of crossed edges
// with that diagonal are two faces on the blade. Of the diagonals allowed the shortest is taken. Neighbours are green:
// a point on 1 edge (2 elements), on 2 edges of a face (3), on 2 opposite edges (4), on the 3 edges of a face (4).
// Whatever else comes out is red too, and so on; it ends at the latest when everything is red.
//
// Neighbours of 1:17 elements are closed by pulling: every face is fanned from its least point (points on faces first,
// then on edges, then corners; by id), and the element is coned from its least point. What is done to a face depends on
// the face alone, so both its elements agree.
//
// Where the blade runs through corners of a crossed element otherwise (two corners; any, for red) no pattern puts the
// section on faces: such elements are closed like neighbours, and what the blade still crosses is bisected. The same
// holds of 1:17 where a blade twists so much within an element that parts of it would be turned over.

#include "mesh/cutting/store/cut_types.h"
#include "mesh/cutting/stroke/cut_moves.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// Is there more to it than bisecting crossed edges?
constexpr bool has_own_patterns(Subdivision subdivision)
{
    return subdivision == Subdivision::general || subdivision == Subdivision::intermediate_5;
}

/// Divides the crossed elements of a stroke and closes their neighbours; new vertices on the blade are marked so.
/// @pre has_own_patterns(options.subdivision); the elements live and are crossed.
void divide_by_pattern(StrokeState& stroke, std::span<const TetId> crossed);

/// The elements that a blade crosses before anything is moved, by id: what increases are counted against.
std::vector<TetId> crossed_elements(const TetMesh& mesh, const SweptBlade& blade);

} // namespace retractor::mesh
