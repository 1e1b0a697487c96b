#include "datasets/phantoms/palpation_scene_file.h"

#include "datasets/io/strict_json.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/tetrahedra/mesh_io.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace retractor::datasets {

namespace {

    using Json = nlohmann::ordered_json;

    constexpr const char* kFormat = "retractor palpation scene";
    constexpr int kSchema = 1;

    const std::vector<double>& array_of(
        const std::map<std::string, std::vector<double>>& arrays, const char* name, const std::filesystem::path& file)
    {
        const auto found = arrays.find(name);
        if (found == arrays.end())
            throw InputError(std::string("has no array \"") + name + '"', file.string());
        return found->second;
    }

    /// A JSON document and its file. Messages name both.
    struct Document {
        Json json;
        std::string file;

        [[noreturn]] void refuse(const std::string& pointer, const std::string& what) const
        {
            throw InputError(what, file + "#" + pointer);
        }
        const Json& at(const std::string& pointer) const
        {
            const Json::json_pointer place(pointer);
            if (!json.contains(place))
                refuse(pointer, "is missing");
            return json.at(place);
        }
        double number(const std::string& pointer) const
        {
            const Json& value = at(pointer);
            if (!value.is_number() || !std::isfinite(value.get<double>()))
                refuse(pointer, "must be a finite number");
            return value.get<double>();
        }
        std::string text(const std::string& pointer) const
        {
            const Json& value = at(pointer);
            if (!value.is_string())
                refuse(pointer, "must be a text");
            return value.get<std::string>();
        }
        Vec3 point(const std::string& pointer) const
        {
            const Json& value = at(pointer);
            if (!value.is_array() || value.size() != 3)
                refuse(pointer, "must be three numbers");
            return { number(pointer + "/0"), number(pointer + "/1"), number(pointer + "/2") };
        }
    };

    Document read_document(const std::filesystem::path& file)
    {
        std::ifstream in(file, std::ios::binary);
        if (!in)
            throw IoError("cannot be read", file.string());
        std::ostringstream text;
        text << in.rdbuf();
        return { parse_strictly(text.str(), file.string()), file.string() };
    }

    Json numbers(const Vec3& v) { return Json::array({ v.x(), v.y(), v.z() }); }

    TouchSite read_site(const Document& document, const std::string& pointer)
    {
        TouchSite site { document.text(pointer + "/name"), document.point(pointer + "/point_mm"),
            document.point(pointer + "/outward") };
        if (!(site.outward.norm() > 1e-6))
            document.refuse(pointer + "/outward", "must not be zero");
        site.outward.normalize();
        return site;
    }

    /// A whole number from `low` to `high`.
    int whole(const Document& document, const std::string& pointer, int low, int high)
    {
        const double value = document.number(pointer);
        if (value != std::floor(value) || value < low || value > high)
            document.refuse(
                pointer, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
        return static_cast<int>(value);
    }

    /// Reads the optional parts of a scene.
    void read_parts(const Document& document, PalpationScene& scene)
    {
        constexpr int kMostParticles = 200;
        if (document.json.contains("sheet_particles"))
            scene.sheet_particles = whole(document, "/sheet_particles", 3, kMostParticles);
        if (!document.json.contains("organs"))
            return;
        const Json& organs = document.at("/organs");
        if (!organs.is_array())
            document.refuse("/organs", "must be a list");
        for (std::size_t i = 0; i < organs.size(); ++i) {
            const std::string pointer = "/organs/" + std::to_string(i);
            const auto label = static_cast<Label>(whole(document, pointer + "/label", 0, 255));
            const auto& labels = scene.body.mesh.labels;
            if (std::find(labels.begin(), labels.end(), label) == labels.end())
                document.refuse(pointer + "/label", "no element has this label");
            scene.organs.push_back({ label, document.text(pointer + "/name") });
        }
    }

} // namespace

void write_elastic_model(const std::filesystem::path& vtu, const ElasticModel& model)
{
    check_elastic_model(model);
    mesh::MeshFields fields;
    std::vector<double>& roles = fields.point_scalars["role"];
    for (const VertexRole role : model.roles)
        roles.push_back(static_cast<double>(role));
    fields.cell_scalars["youngs_modulus_MPa"] = model.youngs_modulus;
    fields.cell_scalars["poissons_ratio"] = model.poissons_ratio;
    mesh::write_vtu(vtu, model.mesh, fields);
}

ElasticModel read_elastic_model(const std::filesystem::path& vtu)
{
    mesh::MeshFields fields;
    ElasticModel model { mesh::read_vtu(vtu, &fields), {}, {}, {} };
    const std::vector<double>& roles = array_of(fields.point_scalars, "role", vtu);
    for (std::size_t v = 0; v < roles.size(); ++v) {
        if (!(roles[v] == 0.0 || roles[v] == 1.0 || roles[v] == 2.0))
            throw InputError(
                "role must be 0 (free), 1 (fixed) or 2 (inner wall)", vtu.string() + ", vertex " + std::to_string(v));
        model.roles.push_back(static_cast<VertexRole>(static_cast<int>(roles[v])));
    }
    model.youngs_modulus = array_of(fields.cell_scalars, "youngs_modulus_MPa", vtu);
    model.poissons_ratio = array_of(fields.cell_scalars, "poissons_ratio", vtu);
    check_elastic_model(model);
    return model;
}

void write_palpation_scene(const std::filesystem::path& file, const PalpationScene& scene)
{
    std::filesystem::path mesh = file;
    mesh.replace_extension(".vtu");
    write_elastic_model(mesh, scene.body);
    Json document { { "format", kFormat }, { "schema", kSchema }, { "name", scene.name }, { "frame", "LPS" },
        { "mesh", mesh.filename().string() },
        { "pressure",
            { { "heart_rate_per_min", scene.heart_rate_per_min }, { "diastolic_mmHg", scene.diastolic_mmHg },
                { "systolic_mmHg", scene.systolic_mmHg }, { "rest_mmHg", scene.rest_mmHg } } },
        { "sites", Json::array() } };
    for (const TouchedOrgan& organ : scene.organs)
        document["organs"].push_back({ { "label", organ.label }, { "name", organ.name } });
    if (scene.sheet_particles > 0)
        document["sheet_particles"] = scene.sheet_particles;
    for (const TouchSite& site : scene.sites)
        document["sites"].push_back(
            { { "name", site.name }, { "point_mm", numbers(site.point) }, { "outward", numbers(site.outward) } });
    write_file_atomically(file, document.dump(2) + "\n");
}

bool is_palpation_scene(const std::filesystem::path& file)
{
    std::error_code none;
    if (!std::filesystem::is_regular_file(file, none))
        return false;
    try {
        const Document document = read_document(file);
        return document.json.is_object() && document.json.contains("format") && document.text("/format") == kFormat;
    } catch (const Error&) {
        return false;
    }
}

PalpationScene read_palpation_scene(const std::filesystem::path& file)
{
    const Document document = read_document(file);
    if (!document.json.is_object() || !document.json.contains("format") || document.text("/format") != kFormat)
        throw InputError(std::string("is no ") + kFormat, file.string());
    if (document.number("/schema") != kSchema)
        document.refuse("/schema", "must be 1");
    if (document.text("/frame") != "LPS")
        document.refuse("/frame", "must be \"LPS\"");
    PalpationScene scene;
    scene.name = document.text("/name");
    scene.heart_rate_per_min = document.number("/pressure/heart_rate_per_min");
    scene.diastolic_mmHg = document.number("/pressure/diastolic_mmHg");
    scene.systolic_mmHg = document.number("/pressure/systolic_mmHg");
    scene.rest_mmHg = document.number("/pressure/rest_mmHg");
    const Json& sites = document.at("/sites");
    if (!sites.is_array())
        document.refuse("/sites", "must be a list");
    for (std::size_t i = 0; i < sites.size(); ++i)
        scene.sites.push_back(read_site(document, "/sites/" + std::to_string(i)));
    const std::string mesh = document.text("/mesh");
    if (mesh.empty() || std::filesystem::path(mesh).has_parent_path())
        document.refuse("/mesh", "must name a file in the same folder");
    scene.body = read_elastic_model(file.parent_path() / mesh);
    read_parts(document, scene);
    return scene;
}

} // namespace retractor::datasets
