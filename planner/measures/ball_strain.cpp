#include "planner/measures/ball_strain.h"

#include "fem/element/tet_element.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/spatial_hash.h"
#include "mesh/base/text_format.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

namespace retractor::planner {

namespace {

    /// An element of the tissue with its mean right stretch, multiplied by its volume.
    struct StretchedElement {
        Vec3 centroid;
        double volume = 0.0; ///< at rest, mm^3
        Mat3 stretch;
    };

    Mat3 right_stretch(const Mat3& F) { return Eigen::SelfAdjointEigenSolver<Mat3>(F.transpose() * F).operatorSqrt(); }

    StretchedElement stretched_element(const mesh::TetMesh& wall, TetId t, const Eigen::VectorXd& displacement)
    {
        const auto ids = wall.tet(t);
        const auto n = static_cast<Eigen::Index>(ids.size());
        fem::NodeGradients moved(n, 3);
        for (Eigen::Index a = 0; a < n; ++a)
            moved.row(a)
                = displacement.segment<3>(3 * static_cast<Eigen::Index>(ids[static_cast<std::size_t>(a)])).transpose();
        StretchedElement element { fem::rest_positions(wall, t).topRows(4).colwise().mean().transpose(), 0.0,
            Mat3::Zero() };
        for (const fem::QuadraturePoint& point : fem::quadrature(wall.nodes_per_tet)) {
            const fem::ShapeGradients shape = fem::shape_gradients(wall, t, point);
            if (!(shape.volume > 0.0))
                continue; // a flat element
            const Mat3 F = Mat3::Identity() + moved.transpose() * shape.gradients;
            element.volume += shape.volume;
            element.stretch += shape.volume * right_stretch(F);
        }
        return element;
    }

    double largest_principal(const Mat3& symmetric)
    {
        return Eigen::SelfAdjointEigenSolver<Mat3>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[2];
    }

    std::string percent(double strain) { return formatted("%.0f %%", 100.0 * strain); }

    std::string place_text(const TissueStrain& tissue)
    {
        return tissue.place.empty() ? "at " + in_words(tissue.at) : tissue.place;
    }

} // namespace

std::optional<BallStrain> largest_ball_strain(const mesh::TetMesh& wall, std::span<const std::uint8_t> in_tissue,
    const Eigen::VectorXd& displacement, double radius_mm)
{
    RETRACTOR_ASSERT(in_tissue.size() == wall.tet_count());
    if (displacement.size() != 3 * wall.vertices.rows())
        throw InputError("the displacement has " + std::to_string(displacement.size()) + " numbers, the wall "
            + std::to_string(wall.vertices.rows()) + " nodes");
    if (!displacement.allFinite())
        throw InputError("the displacement is not finite");
    if (!(radius_mm > 0.0 && std::isfinite(radius_mm)))
        throw InputError("the radius of a ball must be above 0 mm, got " + std::to_string(radius_mm));
    std::vector<StretchedElement> elements;
    SpatialHash<std::size_t> place(0.5 * radius_mm);
    for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t)
        if (in_tissue[static_cast<std::size_t>(t)] != 0) {
            elements.push_back(stretched_element(wall, t, displacement));
            place.add(elements.back().centroid, elements.size() - 1);
        }
    const double least_volume = kLeastFilledBall * 4.0 / 3.0 * std::numbers::pi * std::pow(radius_mm, 3);
    std::optional<BallStrain> largest;
    for (const StretchedElement& centre : elements) {
        double volume = 0.0;
        Mat3 sum = Mat3::Zero();
        place.visit_near(centre.centroid, radius_mm, [&](std::size_t e) {
            const StretchedElement& element = elements[e];
            if ((element.centroid - centre.centroid).squaredNorm() <= radius_mm * radius_mm) {
                volume += element.volume;
                sum += element.stretch;
            }
            return true;
        });
        if (volume < least_volume)
            continue;
        const double strain = largest_principal(sum / volume) - 1.0;
        if (!largest || strain > largest->strain)
            largest = BallStrain { strain, centre.centroid };
    }
    return largest;
}

std::vector<TissueStrain> tissue_strains(
    const mesh::TetMesh& wall, const mesh::LabelTable& table, const Eigen::VectorXd& displacement)
{
    std::map<std::string, std::vector<std::uint8_t>> tissues; // elements of each material
    std::map<Label, std::vector<std::uint8_t>*> of_label;
    for (std::size_t t = 0; t < wall.tet_count(); ++t) {
        const Label label = wall.labels[t];
        const auto [known, is_new] = of_label.try_emplace(label, nullptr);
        if (is_new)
            if (const mesh::LabelInfo* info = mesh::find_label(table, label);
                info != nullptr && info->material != "bone")
                known->second = &tissues.try_emplace(info->material, wall.tet_count(), 0).first->second;
        if (known->second != nullptr)
            (*known->second)[t] = 1;
    }
    std::vector<TissueStrain> strains;
    for (const auto& [material, in_tissue] : tissues)
        if (const auto largest = largest_ball_strain(wall, in_tissue, displacement))
            strains.push_back({ .tissue = material, .strain = largest->strain, .at = largest->at });
    std::ranges::stable_sort(strains, std::greater<>(), &TissueStrain::strain);
    return strains;
}

std::optional<TearingRange> tearing_range(const TissueStrain& tissue)
{
    if (tissue.tissue != "skin")
        return std::nullopt;
    return TearingRange { kSkinTearsFrom, kSkinTearsTo };
}

bool may_tear(const TissueStrain& tissue)
{
    const auto range = tearing_range(tissue);
    return range && tissue.strain > range->from;
}

bool would_tear(const TissueStrain& tissue)
{
    const auto range = tearing_range(tissue);
    return range && tissue.strain > range->to;
}

bool any_may_tear(const FieldMetrics& field) { return std::ranges::any_of(field.tissue_strain, may_tear); }

bool any_would_tear(const FieldMetrics& field) { return std::ranges::any_of(field.tissue_strain, would_tear); }

std::string strain_text(const TissueStrain& tissue)
{
    return readable(tissue.tissue) + " " + percent(tissue.strain) + " " + place_text(tissue);
}

std::string tearing_text(const FieldMetrics& field)
{
    std::string text;
    for (const TissueStrain& tissue : field.tissue_strain) {
        if (!may_tear(tissue))
            continue;
        const TearingRange range = tearing_range(tissue).value();
        remark(text,
            readable(tissue.tissue) + (would_tear(tissue) ? " would tear: " : " may tear: ") + percent(tissue.strain)
                + " " + place_text(tissue)
                + formatted(", torn samples failed between %.0f and %.0f %%", 100.0 * range.from, 100.0 * range.to));
    }
    return text;
}

std::string tissue_strain_text(const FieldMetrics& field)
{
    std::string text;
    for (const TissueStrain& tissue : field.tissue_strain)
        remark(text, strain_text(tissue));
    return text.empty() ? text
                        : formatted("largest strain, averaged over balls of %.0f mm radius: ", kBallRadiusMm) + text;
}

} // namespace retractor::planner
