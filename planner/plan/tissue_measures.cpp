#include "planner/plan/tissue_measures.h"

#include "mesh/base/text_format.h"
#include "mesh/cutting/store/blade.h"
#include "planner/measures/ball_strain.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

std::string place_beside_incision(const Approach& approach, const Vec3& place)
{
    const mesh::SweptBlade blade(blade_of(approach));
    const mesh::BladeCoordinates at = blade.coordinates(place);
    std::string text;
    if (at.along < 0.0)
        text = formatted("%.0f mm before the start of the incision", -at.along);
    else if (at.along > blade.length())
        text = formatted("%.0f mm beyond the end of the incision", at.along - blade.length());
    else
        text = formatted("%.0f mm along the incision", at.along);
    return text + formatted(", %.0f mm beside it and %.0f mm deep", std::abs(at.side), std::max(0.0, at.depth));
}

void measure_tissue_strain(PlannedField& field, const OpenedWound& wound, const mesh::LabelTable& table)
{
    FieldMetrics& m = field.metrics;
    m.tissue_strain.clear();
    if (!is_usable(field.opening))
        return;
    mesh::TetMesh mesh = field.problem.mesh;
    mesh.labels = field.wall.labels; // stiffened elements have labels of their own in the problem
    m.tissue_strain = tissue_strains(mesh, table, displacement_at_nodes(field, wound));
    for (TissueStrain& tissue : m.tissue_strain)
        tissue.place = place_beside_incision(field.approach, tissue.at);
}

} // namespace retractor::planner
