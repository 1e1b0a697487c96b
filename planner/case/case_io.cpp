#include "planner/case/case_io.h"

#include "datasets/io/strict_json.h"
#include "fem/material/element_fibres.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <nlohmann/json.hpp>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <variant>

namespace retractor::planner {

namespace fs = std::filesystem;

namespace {

    using Json = nlohmann::ordered_json;

    // ---- checksums -------------------------------------------------------------------------------------------------

    class Sha256 {
    public:
        Sha256()
        {
            if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
                throw IoError("SHA-256 is not available in this machine's OpenSSL");
        }
        void add(const void* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
        std::string hexadecimal()
        {
            std::array<unsigned char, EVP_MAX_MD_SIZE> digest {};
            unsigned int size = 0;
            EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
            std::string text;
            for (unsigned int n = 0; n < size; ++n) {
                text += "0123456789abcdef"[digest[n] >> 4];
                text += "0123456789abcdef"[digest[n] & 15];
            }
            return text;
        }

    private:
        struct Free {
            void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
        };
        std::unique_ptr<EVP_MD_CTX, Free> context_ { EVP_MD_CTX_new() };
    };

    std::string file_checksum(const fs::path& path)
    {
        std::ifstream file(path, std::ios::binary);
        if (!file)
            throw IoError("cannot be read", path.string());
        Sha256 sum;
        std::vector<char> buffer(1 << 20);
        while (file) {
            file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
            sum.add(buffer.data(), static_cast<std::size_t>(file.gcount()));
        }
        if (file.bad())
            throw IoError("reading failed", path.string());
        return sum.hexadecimal();
    }

    // ---- reading: a value together with its JSON pointer -----------------------------------------------------------

    class Node {
    public:
        Node(const Json& json, std::string pointer)
            : json_(json)
            , pointer_(std::move(pointer))
        {
        }

        [[noreturn]] void refuse(const std::string& what) const
        {
            throw InputError(what, pointer_.empty() ? "/" : pointer_);
        }

        /// Checks for an object with these keys and no others.
        const Node& object(std::initializer_list<std::string_view> required,
            std::initializer_list<std::string_view> optional = {}) const
        {
            expect(json_.is_object(), "an object");
            for (const auto& [key, value] : json_.items())
                if (std::find(required.begin(), required.end(), key) == required.end()
                    && std::find(optional.begin(), optional.end(), key) == optional.end())
                    throw InputError("unknown key \"" + key + "\"", child_pointer(key));
            for (const std::string_view key : required)
                if (!json_.contains(key))
                    throw InputError("the key \"" + std::string(key) + "\" is missing", child_pointer(key));
            return *this;
        }
        bool is_object() const { return json_.is_object(); }
        bool has(std::string_view key) const { return json_.contains(key); }
        Node operator[](std::string_view key) const { return { json_.at(std::string(key)), child_pointer(key) }; }

        double number() const
        {
            expect(json_.is_number(), "a number");
            const double value = json_.get<double>();
            if (!std::isfinite(value))
                refuse("must be a finite number");
            return value;
        }
        int integer(int low, int high) const
        {
            expect(json_.is_number_integer(), "a whole number");
            const bool fits = json_.is_number_unsigned()
                ? json_.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::max(high, 0))
                : json_.get<std::int64_t>() <= high;
            if (!fits || json_.get<std::int64_t>() < low)
                refuse("must be between " + std::to_string(low) + " and " + std::to_string(high));
            return json_.get<int>();
        }
        bool boolean() const
        {
            expect(json_.is_boolean(), "true or false");
            return json_.get<bool>();
        }
        std::string text() const
        {
            expect(json_.is_string(), "a text");
            return json_.get<std::string>();
        }
        Vec3 point() const
        {
            expect(json_.is_array() && json_.size() == 3, "three numbers");
            const auto numbers = list<double>([](const Node& n) { return n.number(); });
            return { numbers[0], numbers[1], numbers[2] };
        }
        template <typename T, typename Read> std::vector<T> list(Read&& read) const
        {
            expect(json_.is_array(), "a list");
            std::vector<T> values;
            values.reserve(json_.size());
            for (std::size_t n = 0; n < json_.size(); ++n)
                values.push_back(read(Node(json_[n], pointer_ + "/" + std::to_string(n))));
            return values;
        }
        std::vector<double> numbers() const
        {
            return list<double>([](const Node& n) { return n.number(); });
        }
        std::vector<std::string> texts() const
        {
            return list<std::string>([](const Node& n) { return n.text(); });
        }
        std::vector<Vec3> points() const
        {
            return list<Vec3>([](const Node& n) { return n.point(); });
        }
        void must_be(std::string_view expected) const
        {
            if (text() != expected)
                refuse("must be \"" + std::string(expected) + "\", got \"" + text() + "\"");
        }

    private:
        std::string child_pointer(std::string_view key) const
        {
            std::string escaped; // RFC 6901
            for (const char c : key)
                escaped += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
            return pointer_ + "/" + escaped;
        }
        void expect(bool right, std::string_view what) const
        {
            if (!right)
                refuse("must be " + std::string(what) + ", got " + json_.type_name());
        }
        const Json& json_;
        std::string pointer_;
    };

    // ---- each section, read and written side by side ---------------------------------------------------------------

    Json written(const Vec3& v) { return Json::array({ v.x(), v.y(), v.z() }); }

    Json written(const std::vector<Vec3>& points)
    {
        Json list = Json::array();
        for (const Vec3& point : points)
            list.push_back(written(point));
        return list;
    }

    Json written(const mesh::LabelInfo& info);
    Json written(const fem::Material& material);
    Json written(const PressureSpec& pressure);
    Json written(const HookSpec& hook);
    Json written(const AblationSpec& ablation);
    Json written(const Approach& approach);

    template <typename T> Json written_list(const std::vector<T>& items)
    {
        Json list = Json::array();
        for (const T& item : items)
            list.push_back(written(item));
        return list;
    }

    FileReference read_reference(const Node& node)
    {
        return { .path = node["path"].text(), .sha256 = node["sha256"].text() };
    }

    Json written(const FileReference& file)
    {
        return { { "path", file.path.generic_string() }, { "sha256", file.sha256 } };
    }

    mesh::LabelInfo read_label(const Node& node)
    {
        node.object({ "id", "name", "material", "role" });
        const auto role = mesh::role_from_string(node["role"].text());
        if (!role)
            node["role"].refuse("unknown role \"" + node["role"].text() + "\": use wall, voxel, target or at-risk");
        return { .id = static_cast<Label>(node["id"].integer(0, std::numeric_limits<Label>::max())),
            .name = node["name"].text(),
            .material = node["material"].text(),
            .role = *role };
    }

    Json written(const mesh::LabelInfo& info)
    {
        return { { "id", info.id }, { "name", info.name }, { "material", info.material },
            { "role", std::string(to_string(info.role)) } };
    }

    fem::TissueLaw with_fibres(const fem::Hyperelastic& law, const Node& node, std::size_t families)
    {
        if (node.is_object()) {
            node.object({ "around", "angle_deg" });
            const Node around = node["around"];
            around.object({ "point_mm", "axis" });
            const fem::FibresAround fibres { .point = around["point_mm"].point(),
                .axis = around["axis"].point(),
                .angle_deg = node["angle_deg"].number() };
            try {
                fem::check_fibres_around(fibres, {});
            } catch (const InputError& error) {
                node.refuse(error.what());
            }
            return { .law = law, .around = fibres };
        }
        const std::vector<Vec3> fibres = node.points();
        if (fibres.empty() || fibres.size() > families)
            node.refuse("must be " + std::string(families == 1 ? "one direction" : "one or two directions")
                + ", or {\"around\": {\"point_mm\", \"axis\"}, \"angle_deg\"}");
        for (const Vec3& fibre : fibres)
            if (!(fibre.norm() > 0.0))
                node.refuse("a direction must not be zero");
        return { law, { fibres.front().normalized(), fibres.back().normalized() } };
    }

    // One overload per law, so that the compiler asks for those of a new law. A neo-Hookean material has no law here.

    std::optional<fem::TissueLaw> read_if(const fem::NeoHookean&, const std::string&, const Node&)
    {
        return std::nullopt;
    }
    std::optional<fem::TissueLaw> read_if(const fem::MooneyRivlin&, const std::string& model, const Node& node)
    {
        if (model != "mooney-rivlin")
            return std::nullopt;
        node.object({ "model", "c10_MPa", "c01_MPa" });
        return fem::TissueLaw { fem::MooneyRivlin {
            .c10 = node["c10_MPa"].number(), .c01 = node["c01_MPa"].number() } };
    }
    std::optional<fem::TissueLaw> read_if(const fem::HolzapfelGasserOgden&, const std::string& model, const Node& node)
    {
        if (model != "holzapfel-gasser-ogden")
            return std::nullopt;
        node.object({ "model", "mu_MPa", "k1_MPa", "k2", "dispersion", "fibres" });
        return with_fibres(fem::HolzapfelGasserOgden { .mu = node["mu_MPa"].number(),
                               .k1 = node["k1_MPa"].number(),
                               .k2 = node["k2"].number(),
                               .dispersion = node["dispersion"].number() },
            node["fibres"], 2);
    }
    std::optional<fem::TissueLaw> read_if(const fem::Guccione&, const std::string& model, const Node& node)
    {
        if (model != "guccione")
            return std::nullopt;
        node.object({ "model", "C_MPa", "bf", "bt", "bfs", "fibres" });
        return with_fibres(fem::Guccione { .C = node["C_MPa"].number(),
                               .bf = node["bf"].number(),
                               .bt = node["bt"].number(),
                               .bfs = node["bfs"].number() },
            node["fibres"], 1);
    }

    /// The law with this model, if any; asks each law of the variant.
    template <class... Laws>
    std::optional<fem::TissueLaw> read_model(const std::variant<Laws...>&, const std::string& model, const Node& node)
    {
        std::optional<fem::TissueLaw> law;
        (void)((law = read_if(Laws {}, model, node)).has_value() || ...);
        return law;
    }

    fem::TissueLaw read_law(const Node& node)
    {
        node.object({ "model" },
            { "c10_MPa", "c01_MPa", "mu_MPa", "k1_MPa", "k2", "dispersion", "C_MPa", "bf", "bt", "bfs", "fibres" });
        const std::string model = node["model"].text();
        if (const std::optional<fem::TissueLaw> law = read_model(fem::Hyperelastic {}, model, node))
            return *law;
        node["model"].refuse("unknown model \"" + model
            + "\": use mooney-rivlin, holzapfel-gasser-ogden or guccione; without a law tissue is neo-Hookean");
    }

    Json written_fibres(const fem::TissueLaw& tissue, std::size_t families)
    {
        if (tissue.around)
            return { { "around",
                         { { "point_mm", written(tissue.around->point) }, { "axis", written(tissue.around->axis) } } },
                { "angle_deg", tissue.around->angle_deg } };
        Json directions = Json::array({ written(tissue.fibres.first) });
        if (families > 1)
            directions.push_back(written(tissue.fibres.second));
        return directions;
    }

    Json written_as(const fem::NeoHookean&, const fem::TissueLaw&)
    {
        throw InputError("a neo-Hookean material is one without a law", "/materials");
    }
    Json written_as(const fem::MooneyRivlin& law, const fem::TissueLaw&)
    {
        return { { "model", "mooney-rivlin" }, { "c10_MPa", law.c10 }, { "c01_MPa", law.c01 } };
    }
    Json written_as(const fem::HolzapfelGasserOgden& law, const fem::TissueLaw& tissue)
    {
        return { { "model", "holzapfel-gasser-ogden" }, { "mu_MPa", law.mu }, { "k1_MPa", law.k1 }, { "k2", law.k2 },
            { "dispersion", law.dispersion }, { "fibres", written_fibres(tissue, 2) } };
    }
    Json written_as(const fem::Guccione& law, const fem::TissueLaw& tissue)
    {
        return { { "model", "guccione" }, { "C_MPa", law.C }, { "bf", law.bf }, { "bt", law.bt }, { "bfs", law.bfs },
            { "fibres", written_fibres(tissue, 1) } };
    }

    Json written(const fem::TissueLaw& tissue)
    {
        return std::visit([&](const auto& law) { return written_as(law, tissue); }, tissue.law);
    }

    /// Tissue without "across" is free to narrow.
    fem::PreStrain read_pre_strain(const Node& node)
    {
        node.object({ "along" }, { "across", "direction", "normal" });
        fem::PreStrain tension { .kind = fem::PreStrainKind::uniaxial_stress, .strain = node["along"].number() };
        if (node.has("across")) {
            tension.kind = fem::PreStrainKind::biaxial;
            tension.across = node["across"].number();
        }
        const auto read_direction = [&](std::string_view key, Vec3& direction) {
            if (!node.has(key))
                return;
            direction = node[key].point();
            if (direction.isZero(0.0))
                node[key].refuse("a direction must not be zero");
        };
        read_direction("direction", tension.pull);
        read_direction("normal", tension.normal);
        return tension;
    }

    Json written(const fem::PreStrain& tension)
    {
        Json json { { "along", tension.strain } };
        switch (tension.kind) {
        case fem::PreStrainKind::uniaxial_stress:
            break;
        case fem::PreStrainKind::held_width:
            json["across"] = 0.0;
            break;
        case fem::PreStrainKind::biaxial:
            json["across"] = tension.across;
            break;
        case fem::PreStrainKind::equibiaxial:
            json["across"] = tension.strain;
            break;
        case fem::PreStrainKind::none:
        case fem::PreStrainKind::isotropic:
            throw InputError("a case holds tension in the tissue's plane only", "/materials");
        }
        if (!tension.pull.isZero(0.0))
            json["direction"] = written(tension.pull);
        if (!tension.normal.isZero(0.0))
            json["normal"] = written(tension.normal);
        return json;
    }

    fem::Material read_material(const Node& node)
    {
        node.object({ "name", "youngs_modulus_MPa", "poissons_ratio", "density_tonne_per_mm3", "source" },
            { "law", "pre_strain" });
        return { .name = node["name"].text(),
            .youngs_modulus_MPa = node["youngs_modulus_MPa"].number(),
            .poissons_ratio = node["poissons_ratio"].number(),
            .density_tonne_per_mm3 = node["density_tonne_per_mm3"].number(),
            .source = node["source"].text(),
            .law = node.has("law") ? std::optional(read_law(node["law"])) : std::nullopt,
            .pre_strain = node.has("pre_strain") ? read_pre_strain(node["pre_strain"]) : fem::PreStrain {} };
    }

    Json written(const fem::Material& material)
    {
        Json json { { "name", material.name }, { "youngs_modulus_MPa", material.youngs_modulus_MPa },
            { "poissons_ratio", material.poissons_ratio }, { "density_tonne_per_mm3", material.density_tonne_per_mm3 },
            { "source", material.source } };
        if (material.law)
            json["law"] = written(*material.law);
        if (material.pre_strain.kind != fem::PreStrainKind::none)
            json["pre_strain"] = written(material.pre_strain);
        return json;
    }

    SolverSettings read_solution(const Node& node)
    {
        if (node.is_object() && node.has("local"))
            node["local"].refuse(
                "the submodel was removed: it held the wall beyond a distance still, and its forces came "
                "out too large; near_mm does it right and solves that wall as linear");
        node.object({}, { "elasticity", "element", "near_mm" });
        SolverSettings choice;
        if (node.has("elasticity")) {
            const auto elasticity = elasticity_from_string(node["elasticity"].text());
            if (!elasticity)
                node["elasticity"].refuse("must be linear, corotational or hyperelastic");
            choice.elasticity = *elasticity;
        }
        if (node.has("element")) {
            const auto element = element_from_string(node["element"].text());
            if (!element)
                node["element"].refuse("must be p1, locking-free or p2");
            choice.element = *element;
        }
        if (node.has("near_mm"))
            choice.near_mm = node["near_mm"].number();
        return choice;
    }

    Json written(const SolverSettings& choice)
    {
        Json json { { "elasticity", to_string(choice.elasticity) }, { "element", to_string(choice.element) } };
        if (choice.near_mm > 0.0)
            json["near_mm"] = choice.near_mm;
        return json;
    }

    PressureSpec read_pressure(const Node& node)
    {
        node.object({ "label", "pressure_kPa" });
        return { .label = node["label"].text(), .pressure_kPa = node["pressure_kPa"].number() };
    }

    Json written(const PressureSpec& pressure)
    {
        return { { "label", pressure.label }, { "pressure_kPa", pressure.pressure_kPa } };
    }

    SizingSpec read_sizing(const Node& node)
    {
        node.object({ "corridor_radius_mm", "corridor_edge_mm", "coarse_edge_mm", "region_mm" });
        return { .corridor_radius_mm = node["corridor_radius_mm"].number(),
            .corridor_edge_mm = node["corridor_edge_mm"].number(),
            .coarse_edge_mm = node["coarse_edge_mm"].number(),
            .region_mm = node["region_mm"].number() };
    }

    Json written(const SizingSpec& sizing)
    {
        return { { "corridor_radius_mm", sizing.corridor_radius_mm }, { "corridor_edge_mm", sizing.corridor_edge_mm },
            { "coarse_edge_mm", sizing.coarse_edge_mm }, { "region_mm", sizing.region_mm } };
    }

    TargetSpec read_target(const Node& node)
    {
        node.object({}, { "label", "centre_mm", "radius_mm" });
        if (node.has("label")) {
            node.object({ "label" }); // a label and a sphere contradict each other
            if (node["label"].text().empty())
                node["label"].refuse("must not be empty");
            return { .label = node["label"].text(), .centre = Vec3::Zero() };
        }
        node.object({ "centre_mm", "radius_mm" });
        return { .label = {}, .centre = node["centre_mm"].point(), .radius_mm = node["radius_mm"].number() };
    }

    Json written(const TargetSpec& target)
    {
        if (!target.is_sphere())
            return { { "label", target.label } };
        return { { "centre_mm", written(target.centre) }, { "radius_mm", target.radius_mm } };
    }

    ViewSpec read_view(const Node& node)
    {
        node.object({ "eye_distance_mm", "half_angle_deg", "eye_count" });
        return { .eye_distance_mm = node["eye_distance_mm"].number(),
            .half_angle_deg = node["half_angle_deg"].number(),
            .eye_count = node["eye_count"].integer(1, 100000) };
    }

    Json written(const ViewSpec& view)
    {
        return { { "eye_distance_mm", view.eye_distance_mm }, { "half_angle_deg", view.half_angle_deg },
            { "eye_count", view.eye_count } };
    }

    HookSpec read_hook(const Node& node)
    {
        if (node.has("force_N"))
            node.object(
                { "name", "side", "along_mm", "depth_mm", "patch_width_mm", "patch_height_mm", "direction", "force_N" },
                { "opening_mm", "force_limit_N", "grip_N_per_mm" });
        else
            node.object({ "name", "side", "along_mm", "depth_mm", "patch_width_mm", "patch_height_mm", "direction",
                            "opening_mm" },
                { "force_limit_N", "grip_N_per_mm" });
        const auto optional_number
            = [&](std::string_view key) { return node.has(key) ? std::optional(node[key].number()) : std::nullopt; };
        return { .name = node["name"].text(),
            .side = node["side"].integer(-1, 1),
            .along_mm = node["along_mm"].number(),
            .depth_mm = node["depth_mm"].number(),
            .patch_width_mm = node["patch_width_mm"].number(),
            .patch_height_mm = node["patch_height_mm"].number(),
            .direction = node["direction"].point(),
            .opening_mm = optional_number("opening_mm").value_or(0.0),
            .pull
            = { optional_number("force_N"), optional_number("force_limit_N"), optional_number("grip_N_per_mm") } };
    }

    Json written(const HookSpec& hook)
    {
        Json json { { "name", hook.name }, { "side", hook.side }, { "along_mm", hook.along_mm },
            { "depth_mm", hook.depth_mm }, { "patch_width_mm", hook.patch_width_mm },
            { "patch_height_mm", hook.patch_height_mm }, { "direction", written(hook.direction) } };
        if (hook.pull.force_N)
            json["force_N"] = *hook.pull.force_N;
        else
            json["opening_mm"] = hook.opening_mm;
        if (hook.pull.force_limit_N)
            json["force_limit_N"] = *hook.pull.force_limit_N;
        if (hook.pull.grip_N_per_mm)
            json["grip_N_per_mm"] = *hook.pull.grip_N_per_mm;
        return json;
    }

    AblationSpec read_ablation(const Node& node)
    {
        node.object({}, { "label", "from_mm", "to_mm", "along_from_mm", "along_to_mm", "centre_mm", "radius_mm" });
        AblationSpec ablation;
        if (node.has("centre_mm") || node.has("radius_mm")) {
            node.object({ "centre_mm", "radius_mm" }, { "label" }); // a ball and a segment contradict each other
            ablation.centre = node["centre_mm"].point();
            ablation.radius_mm = node["radius_mm"].number();
            if (!ablation.is_ball())
                node["radius_mm"].refuse("must be positive");
        } else {
            node.object({ "label", "from_mm", "to_mm" }, { "along_from_mm", "along_to_mm" });
            ablation.from_mm = node["from_mm"].number();
            ablation.to_mm = node["to_mm"].number();
            if (node.has("along_from_mm"))
                ablation.along_from_mm = node["along_from_mm"].number();
            if (node.has("along_to_mm"))
                ablation.along_to_mm = node["along_to_mm"].number();
        }
        if (node.has("label")) {
            ablation.label = node["label"].text();
            if (ablation.label.empty())
                node["label"].refuse("must not be empty");
        }
        return ablation;
    }

    Json written(const AblationSpec& ablation)
    {
        Json json = Json::object();
        if (!ablation.label.empty())
            json["label"] = ablation.label;
        if (ablation.is_ball()) {
            json["centre_mm"] = written(ablation.centre);
            json["radius_mm"] = ablation.radius_mm;
            return json;
        }
        json["from_mm"] = ablation.from_mm;
        json["to_mm"] = ablation.to_mm;
        if (ablation.along_from_mm)
            json["along_from_mm"] = *ablation.along_from_mm;
        if (ablation.along_to_mm)
            json["along_to_mm"] = *ablation.along_to_mm;
        return json;
    }

    LoosePieces read_loose_pieces(const Node& node)
    {
        const auto policy = loose_pieces_from_string(node.text());
        if (!policy)
            node.refuse("unknown \"" + node.text() + "\": use held, removed or rigid");
        return *policy;
    }

    Approach read_approach(const Node& node)
    {
        // "ablations" and "loose_pieces" were added later. A case without them has no ablations, and its loose pieces
        // are held.
        node.object({ "name", "template", "incision_mm", "directions", "depth_mm", "wall_thickness_mm", "hook_depth_mm",
                        "target", "hooks", "retracted", "uncut_labels", "sizing", "view", "rationale" },
            { "ablations", "loose_pieces" });
        return { .name = node["name"].text(),
            .template_name = node["template"].text(),
            .incision = node["incision_mm"].points(),
            .directions = node["directions"].points(),
            .depth_mm = node["depth_mm"].number(),
            .wall_thickness_mm = node["wall_thickness_mm"].numbers(),
            .hook_depth_mm = node["hook_depth_mm"].numbers(),
            .target = read_target(node["target"]),
            .hooks = node["hooks"].list<HookSpec>(read_hook),
            .retracted = node["retracted"].texts(),
            .uncut_labels = node["uncut_labels"].texts(),
            .ablations = node.has("ablations") ? node["ablations"].list<AblationSpec>(read_ablation)
                                               : std::vector<AblationSpec> {},
            .loose_pieces = node.has("loose_pieces") ? read_loose_pieces(node["loose_pieces"]) : LoosePieces::held,
            .sizing = read_sizing(node["sizing"]),
            .view = read_view(node["view"]),
            .rationale = node["rationale"].text() };
    }

    Json written(const Approach& approach)
    {
        Json json { { "name", approach.name }, { "template", approach.template_name },
            { "incision_mm", written(approach.incision) }, { "directions", written(approach.directions) },
            { "depth_mm", approach.depth_mm }, { "wall_thickness_mm", approach.wall_thickness_mm },
            { "hook_depth_mm", approach.hook_depth_mm }, { "target", written(approach.target) },
            { "hooks", written_list(approach.hooks) }, { "retracted", approach.retracted },
            { "uncut_labels", approach.uncut_labels }, { "sizing", written(approach.sizing) },
            { "view", written(approach.view) }, { "rationale", approach.rationale } };
        if (!approach.ablations.empty())
            json["ablations"] = written_list(approach.ablations);
        if (approach.loose_pieces != LoosePieces::held)
            json["loose_pieces"] = to_string(approach.loose_pieces);
        return json;
    }

    constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kUnits { { { "length", "mm" },
        { "force", "N" }, { "stress", "MPa" }, { "mass", "tonne" }, { "angle", "deg" } } };

    void check_head(const Node& root)
    {
        // The schema is checked first, because another schema may have other keys.
        if (root.has("schema"))
            if (const int schema = root["schema"].integer(0, 1000000); schema != kCaseSchema)
                root["schema"].refuse("the case has schema " + std::to_string(schema) + ", written by "
                    + (schema < kCaseSchema ? "an older" : "a newer") + " program; this program reads schema "
                    + std::to_string(kCaseSchema));
        root.object({ "schema", "frame", "units", "labels", "materials", "supports", "sizing", "approaches", "views" },
            { "contact", "ct", "patient", "pressures", "solution" });
        root["frame"].must_be("LPS");
        const Node units = root["units"];
        units.object({ "length", "force", "stress", "mass", "angle" });
        for (const auto& [quantity, unit] : kUnits)
            units[quantity].must_be(unit);
    }

    Case read_sections(const Node& root, const fs::path& folder)
    {
        check_head(root);
        Case read;
        read.folder = folder;
        if (root.has("patient")) {
            const Node patient = root["patient"];
            patient.object({ "name", "id" });
            read.patient = datasets::PatientIdentity { .name = patient["name"].text(), .id = patient["id"].text() };
        }
        if (root.has("ct"))
            read.ct = read_reference(root["ct"].object({ "path", "sha256" }));
        const Node labels = root["labels"];
        labels.object({ "path", "sha256", "table" });
        read.labels = read_reference(labels);
        read.label_table = labels["table"].list<mesh::LabelInfo>(read_label);
        read.materials = root["materials"].list<fem::Material>(read_material);
        const Node supports = root["supports"];
        supports.object({ "labels", "region_border" });
        read.supports = { .labels = supports["labels"].texts(), .region_border = supports["region_border"].boolean() };
        if (root.has("contact"))
            read.contact = root["contact"].boolean();
        if (root.has("pressures"))
            read.pressures = root["pressures"].list<PressureSpec>(read_pressure);
        if (root.has("solution"))
            read.solution = read_solution(root["solution"]);
        read.sizing = read_sizing(root["sizing"]);
        read.approaches = root["approaches"].list<Approach>(read_approach);
        read.views = root["views"].texts();
        check_case(read);
        return read;
    }

    void check_file(const Case& read, const FileReference& file, const std::string& where, bool verify)
    {
        const fs::path path = read.folder / file.path;
        if (!fs::exists(path))
            throw InputError("there is no \"" + file.path.generic_string() + "\" in the case folder", where + "/path");
        if (verify && checksum(path) != file.sha256)
            throw InputError("\"" + file.path.generic_string()
                    + "\" is not what this case was planned on: its checksum differs; import it again or restore it",
                where + "/sha256");
    }

} // namespace

std::string checksum(const fs::path& path)
{
    std::error_code error;
    if (!fs::is_directory(path, error))
        return file_checksum(path);
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(path, error))
        if (entry.is_regular_file())
            names.push_back(entry.path().lexically_relative(path).generic_string());
    if (error)
        throw IoError("cannot be listed: " + error.message(), path.string());
    std::sort(names.begin(), names.end());
    Sha256 sum;
    for (const std::string& name : names) {
        const std::string line = file_checksum(path / name) + "  " + name + "\n"; // in the format of sha256sum
        sum.add(line.data(), line.size());
    }
    return sum.hexadecimal();
}

FileReference make_reference(const fs::path& case_folder, const fs::path& path)
{
    const fs::path relative
        = fs::absolute(path).lexically_normal().lexically_relative(fs::absolute(case_folder).lexically_normal());
    if (relative.empty() || *relative.begin() == "..")
        throw InputError("must lie inside the case folder " + case_folder.string(), path.string());
    return { .path = relative, .sha256 = checksum(path) };
}

Case case_from_json(const std::string& text, const fs::path& folder)
{
    const Json json = datasets::parse_strictly(text, "/");
    return read_sections(Node(json, ""), folder);
}

Case read_case(const fs::path& path, const ReadCaseOptions& options)
{
    const fs::path file = fs::is_directory(path) ? path / kCaseFileName : path;
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw IoError("cannot be read: give a case file, or the folder of a case.json", file.string());
    std::ostringstream text;
    text << stream.rdbuf();
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    Case read = case_from_json(text.str(), folder);
    read.file_name = file.filename().string();
    check_file(read, read.labels, "/labels", options.verify_checksums);
    if (read.ct)
        check_file(read, *read.ct, "/ct", options.verify_checksums);
    return read;
}

std::string ablation_to_json(const AblationSpec& ablation) { return written(ablation).dump(); }

std::string case_to_json(const Case& planned_case)
{
    check_case(planned_case);
    Json json;
    json["schema"] = kCaseSchema;
    json["frame"] = "LPS";
    for (const auto& [quantity, unit] : kUnits)
        json["units"][std::string(quantity)] = std::string(unit);
    if (planned_case.patient)
        json["patient"] = { { "name", planned_case.patient->name }, { "id", planned_case.patient->id } };
    if (planned_case.ct)
        json["ct"] = written(*planned_case.ct);
    json["labels"] = written(planned_case.labels);
    json["labels"]["table"] = written_list(planned_case.label_table);
    json["materials"] = written_list(planned_case.materials);
    json["supports"]
        = { { "labels", planned_case.supports.labels }, { "region_border", planned_case.supports.region_border } };
    if (planned_case.contact)
        json["contact"] = true;
    if (!planned_case.pressures.empty())
        json["pressures"] = written_list(planned_case.pressures);
    if (!(planned_case.solution == SolverSettings {}))
        json["solution"] = written(planned_case.solution);
    json["sizing"] = written(planned_case.sizing);
    json["approaches"] = written_list(planned_case.approaches);
    json["views"] = planned_case.views;
    try {
        return json.dump(1, '\t') + "\n";
    } catch (const Json::exception& error) {
        throw InputError(std::string("a text is not valid UTF-8: ") + error.what());
    }
}

void write_case(const Case& planned_case) { write_file_atomically(planned_case.file(), case_to_json(planned_case)); }

} // namespace retractor::planner
