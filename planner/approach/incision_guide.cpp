#include "planner/approach/incision_guide.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/smooth_line.h"

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace retractor::planner {

std::vector<LandmarkDistance> landmark_distances(Patient& patient, const Approach& approach)
{
    std::shared_ptr<const Anatomy> anatomy;
    const std::shared_ptr<const mesh::LabelVolume> labels = patient.labels();
    try {
        anatomy = patient.anatomy();
    } catch (const InputError&) { // no landmarks
        return {};
    }
    const BodyProbe probe(*labels);
    // A finger feels the ends of the sternum straight in front of them, not at the nearest skin, which over the notch
    // is that of the neck.
    const Vec3 &forward = anatomy->frame.anterior, &axis = anatomy->sternum.axis;
    const Vec3 ahead = (forward - axis.dot(forward) * axis).normalized();
    std::vector<LandmarkDistance> landmarks;
    for (const auto& [name, bone] : { std::pair("jugular notch", anatomy->sternum.top),
             std::pair("tip of the xiphoid", anatomy->sternum.bottom) }) {
        const std::optional<double> skin = probe.skin_along(bone, ahead);
        if (!skin)
            continue; // the image ends here
        const Vec3 at = bone + *skin * ahead;
        landmarks.push_back({ .landmark = name,
            .at = at,
            .to_start_mm = (approach.incision.front() - at).norm(),
            .to_end_mm = (approach.incision.back() - at).norm() });
    }
    return landmarks;
}

namespace {

    /// "82 mm right of the midline".
    std::string beside_midline(const AnatomicalFrame& frame, const Vec3& on_midline, const Vec3& point)
    {
        constexpr double kOnItMm = 5.0;
        const double left_mm = frame.left.dot(point - on_midline);
        if (std::abs(left_mm) < kOnItMm)
            return "on the midline";
        return in_words(std::round(std::abs(left_mm))) + " mm to the patient's " + (left_mm > 0.0 ? "left" : "right")
            + " of the midline";
    }

} // namespace

std::vector<std::string> theatre_sentences(Patient& patient, const Approach& approach)
{
    const std::vector<LandmarkDistance> landmarks = landmark_distances(patient, approach);
    std::vector<std::string> sentences;
    if (landmarks.empty())
        return sentences;
    const AnatomicalFrame frame = patient.frame();
    sentences.push_back("The incision starts " + beside_midline(frame, landmarks.front().at, approach.incision.front())
        + " and ends " + beside_midline(frame, landmarks.front().at, approach.incision.back()) + ".");
    for (const LandmarkDistance& landmark : landmarks)
        sentences.push_back("From the " + landmark.landmark + " " + in_words(std::round(landmark.to_start_mm))
            + " mm to its start and " + in_words(std::round(landmark.to_end_mm))
            + " mm to its end, in a straight line.");
    return sentences;
}

namespace {

    /// The places of a bar on the skin beside the incision: four corners at every point.
    TriMesh bar(const Approach& approach, double from_mm, double to_mm, double thickness_mm)
    {
        const std::vector<Vec3> along = tangents(approach.incision);
        const std::size_t count = approach.incision.size();
        TriMesh mesh;
        mesh.vertices.resize(static_cast<Eigen::Index>(4 * count), 3);
        for (std::size_t n = 0; n < count; ++n) {
            const Vec3 outward = -approach.directions[n].normalized();
            const Vec3 across = outward.cross(along[n]).normalized();
            const Vec3& skin = approach.incision[n];
            const std::array<Vec3, 4> corners { skin + from_mm * across, skin + to_mm * across,
                skin + to_mm * across + thickness_mm * outward, skin + from_mm * across + thickness_mm * outward };
            for (std::size_t k = 0; k < 4; ++k)
                mesh.vertices.row(static_cast<Eigen::Index>(4 * n + k)) = corners[k].transpose();
        }
        const auto id = [](std::size_t n, std::size_t k) { return static_cast<VertexId>(4 * n + k % 4); };
        const auto add = [&](VertexId a, VertexId b, VertexId c, VertexId d) {
            mesh.triangles.push_back({ a, b, c });
            mesh.triangles.push_back({ a, c, d });
        };
        for (std::size_t n = 0; n + 1 < count; ++n)
            for (std::size_t k = 0; k < 4; ++k)
                add(id(n, k), id(n, k + 1), id(n + 1, k + 1), id(n + 1, k));
        add(id(0, 3), id(0, 2), id(0, 1), id(0, 0));
        add(id(count - 1, 0), id(count - 1, 1), id(count - 1, 2), id(count - 1, 3));
        return mesh;
    }

    void append(TriMesh& mesh, const TriMesh& other)
    {
        const auto first = static_cast<VertexId>(mesh.vertices.rows());
        Points all(mesh.vertices.rows() + other.vertices.rows(), 3);
        all << mesh.vertices, other.vertices;
        mesh.vertices = std::move(all);
        for (auto triangle : other.triangles) {
            for (VertexId& v : triangle)
                v += first;
            mesh.triangles.push_back(triangle);
        }
    }

} // namespace

TriMesh guide_ribbon(const Approach& approach, double width_mm, double slit_mm, double thickness_mm)
{
    RETRACTOR_ASSERT(approach.incision.size() >= 2 && width_mm > 0.0 && slit_mm > 0.0 && thickness_mm > 0.0);
    TriMesh ribbon = bar(approach, 0.5 * slit_mm, 0.5 * slit_mm + width_mm, thickness_mm);
    append(ribbon, bar(approach, -0.5 * slit_mm - width_mm, -0.5 * slit_mm, thickness_mm));
    return ribbon;
}

std::string slicer_markup(const Approach& approach)
{
    using Json = nlohmann::ordered_json;
    Json points = Json::array();
    for (std::size_t n = 0; n < approach.incision.size(); ++n)
        points.push_back({ { "id", std::to_string(n + 1) }, { "label", approach.name + "-" + std::to_string(n + 1) },
            { "position", { approach.incision[n].x(), approach.incision[n].y(), approach.incision[n].z() } },
            { "selected", true }, { "locked", true }, { "visibility", n == 0 || n + 1 == approach.incision.size() },
            { "positionStatus", "defined" } });
    const Json markup { { "type", "Curve" }, { "coordinateSystem", "LPS" }, { "coordinateUnits", "mm" },
        { "locked", true }, { "controlPoints", points } };
    const Json document {
        { "@schema",
            "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
            "markups-schema-v1.0.3.json#" },
        { "markups", { markup } }
    };
    return document.dump(2) + "\n";
}

} // namespace retractor::planner
