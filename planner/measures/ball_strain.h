#pragma once
// Strain of each tissue averaged over balls, compared with the strain at which tissue tears. Units mm; frame patient
// LPS, at rest.
//
// The strain of a single element has no bound under refinement at the ends of a wound and at the edges of blades. A
// mean over a ball of fixed size has a limit, and compares with the mean over the gauge length of a torn sample.
// - The mean is that of the right stretch tensor U of F = R U, by volume, over the elements of one tissue whose
//   centroids lie within kBallRadiusMm (a radius) of the centroid of an element of this tissue.
// - The strain is the largest principal value of this mean less 1: elongation over length, as torn samples are
//   reported.
// - Not the mean of F: lips roll outwards in opposite directions, and a mean of unlike rotations hides stretch. Not the
//   mean of Green's strain: its square counts the unbounded strain of a few elements too much.
// - Ten-node elements are taken at their own displacement, at the four points of their quadrature rule.
//
// Skin: samples of the back of seven bodies tore at an elongation of 54 +- 17 % (mean and standard deviation; Ni
// Annaidh, Bruyere, Destrade, Gilchrist, Ottenio 2012, J Mech Behav Biomed Mater 5:139, doi
// 10.1016/j.jmbbm.2011.08.016, arXiv 1302.3022). The samples had lost the tension that skin has in the body, so skin in
// the body tears somewhat earlier. No numbers for other tissues are used here.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/measures/field_metrics.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Radius of the balls, mm.
inline constexpr double kBallRadiusMm = 5.0;

/// Balls that hold less of the tissue than this share of their volume are left out: so little is no mean (ours).
inline constexpr double kLeastFilledBall = 0.05;

/// One standard deviation round the mean strain at which samples of skin tore.
inline constexpr double kSkinTearsFrom = 0.37, kSkinTearsTo = 0.71;

struct BallStrain {
    double strain = 0.0; ///< largest principal stretch of the mean less 1
    Vec3 at = Vec3::Zero(); ///< centre of the ball at rest, mm
};

/// The ball with the largest strain; nothing where no ball holds enough of the tissue.
/// @param in_tissue 1 for each element of the tissue, else 0
/// @param displacement of all nodes of the wall, mm, three per node
/// @throws InputError on a displacement of another size or that is not finite, and on a radius that is not positive
std::optional<BallStrain> largest_ball_strain(const mesh::TetMesh& wall, std::span<const std::uint8_t> in_tissue,
    const Eigen::VectorXd& displacement, double radius_mm = kBallRadiusMm);

/// The largest ball strain of each material of the wall but bone, the largest first. Elements of one material are one
/// tissue, whatever their labels; labels that are not in the table are left out.
/// @param displacement as for largest_ball_strain()
/// @throws InputError as largest_ball_strain() does
std::vector<TissueStrain> tissue_strains(
    const mesh::TetMesh& wall, const mesh::LabelTable& table, const Eigen::VectorXd& displacement);

/// The strains between which tested samples of this tissue tore; nothing where there is no published number.
struct TearingRange {
    double from = 0.0, to = 0.0;
};
std::optional<TearingRange> tearing_range(const TissueStrain& tissue);

/// Whether a tissue is stretched into the range at which samples tore, or beyond.
bool may_tear(const TissueStrain& tissue);
/// Whether a tissue is stretched beyond that range.
bool would_tear(const TissueStrain& tissue);
bool any_may_tear(const FieldMetrics& field);
bool any_would_tear(const FieldMetrics& field);

/// "skin 82 %, 38 mm along the incision ..." for one tissue.
std::string strain_text(const TissueStrain& tissue);

/// "skin would tear: 82 % at ..., torn samples failed between 37 and 71 %"; empty where nothing may tear.
std::string tearing_text(const FieldMetrics& field);

/// "largest strain, averaged over balls of 5 mm radius: skin 82 % ...; muscle 40 % ..."; empty without strains.
std::string tissue_strain_text(const FieldMetrics& field);

} // namespace retractor::planner
