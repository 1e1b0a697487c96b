#include "planner/case/case_io.h"

#include "datasets/io/strict_json.h"
#include "fem/material/element_fibres.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "planner/case/plausible_input.h"

#include <nlohmann/json.hpp>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <type_traits>
#include <variant>
#include <vector>

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
        void object(
            const std::vector<std::string_view>& required, const std::vector<std::string_view>& optional = {}) const
        {
            expect(json_.is_object(), "an object");
            for (const auto& [key, value] : json_.items())
                if (std::find(required.begin(), required.end(), key) == required.end()
                    && std::find(optional.begin(), optional.end(), key) == optional.end())
                    throw InputError("unknown key \"" + key + "\"", child_pointer(key));
            for (const std::string_view key : required)
                require(key);
        }
        bool is_object() const { return json_.is_object(); }
        bool is_boolean() const { return json_.is_boolean(); }
        bool is_text() const { return json_.is_string(); }
        bool has(std::string_view key) const { return json_.contains(key); }
        /// The value of a key, which must be there.
        Node operator[](std::string_view key) const
        {
            expect(json_.is_object(), "an object");
            require(key);
            return { json_.at(std::string(key)), child_pointer(key) };
        }

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
        void require(std::string_view key) const
        {
            if (!json_.contains(key))
                throw InputError("the key \"" + std::string(key) + "\" is missing", child_pointer(key));
        }
        void expect(bool right, std::string_view what) const
        {
            if (!right)
                refuse("must be " + std::string(what) + ", got " + json_.type_name());
        }
        const Json& json_;
        std::string pointer_;
    };

    // ---- the fields of each section, named once for reading and writing ---------------------------------------------

    template <class T, class Section>
    concept Is = std::same_as<std::remove_const_t<T>, Section>;

    /// Passes each key of a section with its field, in the order of the file, to a FieldKeys, FieldReader or
    /// FieldWriter.
    struct Fields {
        static void of(auto& io, Is<datasets::PatientIdentity> auto& patient)
        {
            io.required("name", patient.name, "id", patient.id);
        }
        static void of(auto& io, Is<FileReference> auto& file)
        {
            io.required("path", file.path, "sha256", file.sha256);
        }
        static void of(auto& io, Is<mesh::LabelInfo> auto& info)
        {
            io.integer("id", info.id, 0, std::numeric_limits<Label>::max());
            io.required("name", info.name, "material", info.material, "role", info.role);
        }
        static void of(auto& io, Is<fem::MooneyRivlin> auto& law)
        {
            io.required("c10_MPa", law.c10, "c01_MPa", law.c01);
        }
        static void of(auto& io, Is<fem::HolzapfelGasserOgden> auto& law)
        {
            io.required("mu_MPa", law.mu, "k1_MPa", law.k1, "k2", law.k2, "dispersion", law.dispersion);
        }
        static void of(auto& io, Is<fem::Guccione> auto& law)
        {
            io.required("C_MPa", law.C, "bf", law.bf, "bt", law.bt, "bfs", law.bfs);
        }
        static void of(auto& io, Is<fem::FibresAround> auto& fibres)
        {
            io.section("around", [&](auto& around) { around.required("point_mm", fibres.point, "axis", fibres.axis); });
            io.required("angle_deg", fibres.angle_deg);
        }
        static void of(auto& io, Is<fem::Material> auto& material)
        {
            io.required("name", material.name, "youngs_modulus_MPa", material.youngs_modulus_MPa, "poissons_ratio",
                material.poissons_ratio, "density_tonne_per_mm3", material.density_tonne_per_mm3, "source",
                material.source);
            io.optional("law", material.law);
            io.optional("pre_strain", material.pre_strain, material.pre_strain.kind != fem::PreStrainKind::none);
        }
        static void of(auto& io, Is<SupportSpec> auto& supports)
        {
            io.required("labels", supports.labels, "region_border", supports.region_border);
        }
        static void of(auto& io, Is<SolverSettings> auto& choice)
        {
            io.optional("elasticity", choice.elasticity, true);
            io.optional("element", choice.element, true);
            io.optional("near_mm", choice.near_mm, choice.near_mm > 0.0);
            io.optional("accuracy", choice.accuracy);
        }
        static void of(auto& io, Is<AccuracyGoal> auto& goal)
        {
            io.optional("force", goal.force, true);
            io.optional("opening", goal.opening_mm, true);
            io.optional("time", goal.time_s, true);
        }
        static void of(auto& io, Is<PressureSpec> auto& pressure)
        {
            io.required("label", pressure.label, "pressure_kPa", pressure.pressure_kPa);
        }
        static void of(auto& io, Is<AssumedVessel> auto& vessel)
        {
            io.required("name", vessel.name, "line_mm", vessel.line, "radius_mm", vessel.radius_mm);
        }
        static void of(auto& io, Is<SizingSpec> auto& sizing)
        {
            io.required("corridor_radius_mm", sizing.corridor_radius_mm, "corridor_edge_mm", sizing.corridor_edge_mm,
                "coarse_edge_mm", sizing.coarse_edge_mm);
            io.optional("region_mm", sizing.region_mm);
        }
        static void of(auto& io, Is<TargetSpec> auto& target)
        {
            if (io.chosen("label", !target.is_sphere())) { // a label and a sphere contradict each other
                io.required("label", target.label);
                if (!io.chosen("site", target.is_site()))
                    return;
                io.required("site", target.site);
            }
            io.required("centre_mm", target.centre, "radius_mm", target.radius_mm);
            io.optional("normal", target.normal);
        }
        static void of(auto& io, Is<ViewSpec> auto& view)
        {
            io.required("eye_distance_mm", view.eye_distance_mm, "half_angle_deg", view.half_angle_deg);
            io.integer("eye_count", view.eye_count, 1, 100000);
        }
        static void of(auto& io, Is<HookSpec> auto& hook)
        {
            io.required("name", hook.name);
            io.integer("side", hook.side, -1, 1);
            io.required("along_mm", hook.along_mm, "depth_mm", hook.depth_mm, "patch_width_mm", hook.patch_width_mm,
                "patch_height_mm", hook.patch_height_mm, "direction", hook.direction);
            io.optional("force_N", hook.pull.force_N);
            if (io.chosen("force_N", hook.pull.force_N.has_value()))
                io.optional("opening_mm", hook.opening_mm, false); // check_hook() refuses both
            else
                io.required("opening_mm", hook.opening_mm);
            io.optional("force_limit_N", hook.pull.force_limit_N);
            io.optional("grip_N_per_mm", hook.pull.grip_N_per_mm);
            io.optional("hold", hook.hold, hook.hold != HookHold::fixed);
        }
        static void of(auto& io, Is<RetractorSpec> auto& retractor)
        {
            io.required("kind", retractor.kind);
            io.optional("force_N", retractor.force_N);
            if (io.chosen("force_N", retractor.force_N.has_value()))
                io.optional("opening_mm", retractor.opening_mm, false); // check_approach() refuses both
            else
                io.required("opening_mm", retractor.opening_mm);
            io.required("along_mm", retractor.along_mm, "blade_width_mm", retractor.blade_width_mm, "blade_depth_mm",
                retractor.blade_depth_mm, "play_deg", retractor.play_deg, "greatest_opening_mm",
                retractor.greatest_opening_mm);
            io.optional("hold", retractor.hold, retractor.hold != HookHold::contact);
        }
        static void of(auto& io, Is<OpeningProtocol> auto& protocol)
        {
            io.required("turn_mm", protocol.turn_mm, "turns_per_step", protocol.turns_per_step, "wait_s",
                protocol.wait_s, "hold_s", protocol.hold_s);
        }
        static void of(auto& io, Is<AblationSpec> auto& ablation)
        {
            const bool is_ball
                = io.chosen("centre_mm", ablation.is_ball()) || io.chosen("radius_mm", ablation.is_ball());
            if (is_ball) { // a ball and a segment contradict each other
                io.optional("label", ablation.label, !ablation.label.empty());
                io.required("centre_mm", ablation.centre, "radius_mm", ablation.radius_mm);
                return;
            }
            io.required("label", ablation.label, "from_mm", ablation.from_mm, "to_mm", ablation.to_mm);
            io.optional("along_from_mm", ablation.along_from_mm);
            io.optional("along_to_mm", ablation.along_to_mm);
        }
        static void of(auto& io, Is<Division> auto& division)
        {
            io.required("extent", division.extent);
            io.optional("forwards_mm", division.forwards_mm);
            io.optional("backwards_mm", division.backwards_mm);
        }
        static void of(auto& io, Is<Approach> auto& approach)
        {
            io.required("name", approach.name, "template", approach.template_name, "incision_mm", approach.incision,
                "directions", approach.directions, "depth_mm", approach.depth_mm, "wall_thickness_mm",
                approach.wall_thickness_mm, "hook_depth_mm", approach.hook_depth_mm, "target", approach.target, "hooks",
                approach.hooks, "retracted", approach.retracted, "uncut_labels", approach.uncut_labels, "sizing",
                approach.sizing, "view", approach.view, "rationale", approach.rationale);
            // These were added later. A case without them gives no title, divides no tissue beyond the skin, has no
            // retractor and no ablations, opens by half a turn of the crank every 10 s, and its loose pieces are held.
            io.optional("title", approach.title, !approach.title.empty());
            io.optional("division", approach.division, approach.division.extent != DivisionExtent::skin);
            io.optional("retractor", approach.retractor);
            io.optional("opening_protocol", approach.opening_protocol);
            io.optional("ablations", approach.ablations, !approach.ablations.empty());
            io.optional("loose_pieces", approach.loose_pieces, approach.loose_pieces != LoosePieces::held);
        }
        static void of(auto& io, Is<Case> auto& whole)
        {
            io.optional("patient", whole.patient);
            io.optional("ct", whole.ct);
            io.section("labels", [&](auto& labels) {
                Fields::of(labels, whole.labels);
                labels.required("table", whole.label_table);
                labels.optional("estimated", whole.estimated_labels, !whole.estimated_labels.empty());
            });
            io.optional("assumed_vessels", whole.assumed_vessels, !whole.assumed_vessels.empty());
            io.required("materials", whole.materials, "supports", whole.supports);
            io.optional("contact", whole.contact, whole.contact != ContactMode::automatic);
            io.optional("pressures", whole.pressures, !whole.pressures.empty());
            io.optional("solution", whole.solution, !(whole.solution == SolverSettings {}));
            io.required("sizing", whole.sizing, "approaches", whole.approaches, "views", whole.views);
            io.optional("accept_implausible", whole.accept_implausible, whole.accept_implausible);
        }
    };

    /// Name of a law in the file, and the most directions of its fibres.
    struct LawModel {
        std::string_view name;
        std::size_t families = 0;
    };
    template <class Law> constexpr LawModel no_model()
    {
        static_assert(sizeof(Law) == 0, "a new law needs a kModel of its own");
        return {};
    }
    template <class Law> constexpr LawModel kModel = no_model<Law>();
    template <> constexpr LawModel kModel<fem::NeoHookean> {}; // a material without a law: no model in the file
    template <> constexpr LawModel kModel<fem::MooneyRivlin> { "mooney-rivlin", 0 };
    template <> constexpr LawModel kModel<fem::HolzapfelGasserOgden> { "holzapfel-gasser-ogden", 2 };
    template <> constexpr LawModel kModel<fem::Guccione> { "guccione", 1 };

    /// Collects the keys of a section as it is in the file.
    class FieldKeys {
    public:
        FieldKeys(const Node& node, std::vector<std::string_view> more)
            : node_(node)
            , required_(std::move(more))
        {
        }
        bool chosen(std::string_view key, bool) const { return node_.has(key); }
        void required(std::string_view key, const auto&, const auto&... rest)
        {
            required_.push_back(key);
            if constexpr (sizeof...(rest) > 0)
                required(rest...);
        }
        void optional(std::string_view key, const auto&, bool = true) { optional_.push_back(key); }
        void integer(std::string_view key, int, int, int) { required_.push_back(key); }
        void section(std::string_view key, const auto&) { required_.push_back(key); }
        /// Refuses other keys and missing ones.
        void check() const { node_.object(required_, optional_); }

    private:
        const Node& node_;
        std::vector<std::string_view> required_, optional_;
    };

    class FieldReader {
    public:
        /// Reads a section whose fields `body` names.
        /// @param more other keys that the section must have
        static void read_section(const Node& node, std::vector<std::string_view> more, const auto& body)
        {
            FieldKeys keys(node, std::move(more));
            body(keys);
            keys.check();
            FieldReader reader(node);
            body(reader);
        }

        bool chosen(std::string_view key, bool) const { return node_.has(key); }
        void required(std::string_view key, auto& value, auto&... rest)
        {
            read(node_[key], value);
            if constexpr (sizeof...(rest) > 0)
                required(rest...);
        }
        template <class T> void optional(std::string_view key, T& value, bool = true)
        {
            if (node_.has(key))
                read(node_[key], value);
        }
        template <class T> void integer(std::string_view key, T& value, int low, int high)
        {
            value = static_cast<T>(node_[key].integer(low, high));
        }
        void section(std::string_view key, const auto& body) { read_section(node_[key], {}, body); }

    private:
        explicit FieldReader(const Node& node)
            : node_(node)
        {
        }

        static void read(const Node& node, double& value) { value = node.number(); }
        static void read(const Node& node, bool& value) { value = node.boolean(); }
        static void read(const Node& node, std::string& value) { value = node.text(); }
        static void read(const Node& node, fs::path& value) { value = node.text(); }
        static void read(const Node& node, Vec3& value) { value = node.point(); }
        template <class T> static void read(const Node& node, std::optional<T>& value) { read(node, value.emplace()); }
        template <class T> static void read(const Node& node, std::vector<T>& values)
        {
            values = node.list<T>([](const Node& item) {
                T value {};
                read(item, value);
                return value;
            });
        }
        template <class Section> static void read(const Node& node, Section& section)
        {
            read_section(node, {}, [&](auto& io) { Fields::of(io, section); });
        }

        static void read(const Node& node, mesh::Role& role)
        {
            role = known(node, mesh::role_from_string(node.text()),
                "unknown role \"" + node.text() + "\": use wall, voxel, target or at-risk");
        }
        static void read(const Node& node, fem::Elasticity& elasticity)
        {
            elasticity
                = known(node, elasticity_from_string(node.text()), "must be linear, corotational or hyperelastic");
        }
        static void read(const Node& node, ElementKind& element)
        {
            element = known(node, element_from_string(node.text()), "must be p1, locking-free or p2");
        }
        static void read(const Node& node, ContactMode& contact)
        {
            if (node.is_boolean())
                contact = node.boolean() ? ContactMode::always : ContactMode::never;
            else if (node.is_text() && node.text() == to_string(ContactMode::automatic))
                contact = ContactMode::automatic;
            else
                node.refuse("must be true, false or \"auto\"");
        }
        static void read(const Node& node, LoosePieces& policy)
        {
            policy = known(node, loose_pieces_from_string(node.text()),
                "unknown \"" + node.text() + "\": use held, removed or rigid");
        }
        static void read(const Node& node, HookHold& hold)
        {
            hold = known(
                node, hook_hold_from_string(node.text()), "unknown \"" + node.text() + "\": use fixed or contact");
        }
        static void read(const Node& node, DivisionExtent& extent)
        {
            extent = known(node, division_extent_from_string(node.text()),
                "unknown \"" + node.text() + "\": use skin, full, sternum-right, sternum-left or sternum-across");
        }
        template <class T> static T known(const Node& node, const std::optional<T>& value, const std::string& refusal)
        {
            if (!value)
                node.refuse(refusal);
            return *value;
        }

        static void read(const Node& node, SolverSettings& choice)
        {
            if (node.has("local"))
                node["local"].refuse(
                    "the submodel was removed: it held the wall beyond a distance still, and its forces came "
                    "out too large; near_mm does it right and solves that wall as linear");
            read<SolverSettings>(node, choice);
        }
        static void read(const Node& node, TargetSpec& target)
        {
            read<TargetSpec>(node, target);
            refuse_empty_label(node);
            if (node.has("site") && target.site.empty())
                node["site"].refuse("must not be empty: say what is done there, or leave it out");
        }
        static void read(const Node& node, AblationSpec& ablation)
        {
            read<AblationSpec>(node, ablation);
            if (node.has("radius_mm") && !ablation.is_ball())
                node["radius_mm"].refuse("must be positive");
            refuse_empty_label(node);
        }
        static void refuse_empty_label(const Node& node)
        {
            if (node.has("label") && node["label"].text().empty())
                node["label"].refuse("must not be empty");
        }

        /// Tissue without "across" is free to narrow.
        static void read(const Node& node, fem::PreStrain& tension)
        {
            node.object({ "along" }, { "across", "direction", "normal" });
            tension = { .kind = fem::PreStrainKind::uniaxial_stress, .strain = node["along"].number() };
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
        }

        static void read(const Node& node, fem::TissueLaw& tissue)
        {
            const std::string model = node["model"].text();
            if (!read_any_law(node, model, tissue, std::type_identity<fem::Hyperelastic> {})) {
                node["model"].refuse("unknown model \"" + model
                    + "\": use mooney-rivlin, holzapfel-gasser-ogden or guccione; without a law tissue is neo-Hookean");
            }
        }
        /// Reads the law of the variant whose model this is. @returns false when there is none
        template <class... Laws>
        static bool read_any_law(
            const Node& node, std::string_view model, fem::TissueLaw& tissue, std::type_identity<std::variant<Laws...>>)
        {
            return (read_law<Laws>(node, model, tissue) || ...);
        }
        template <class Law> static bool read_law(const Node& node, std::string_view model, fem::TissueLaw& tissue)
        {
            if constexpr (kModel<Law>.name.empty()) {
                return false;
            } else {
                if (model != kModel<Law>.name)
                    return false;
                Law law {};
                std::vector<std::string_view> more { "model" };
                if (kModel<Law>.families > 0)
                    more.emplace_back("fibres");
                read_section(node, std::move(more), [&](auto& io) { Fields::of(io, law); });
                tissue.law = law;
                if (kModel<Law>.families > 0)
                    read_fibres(node["fibres"], kModel<Law>.families, tissue);
                return true;
            }
        }
        static void read_fibres(const Node& node, std::size_t families, fem::TissueLaw& tissue)
        {
            if (node.is_object()) {
                read(node, tissue.around);
                try {
                    fem::check_fibres_around(*tissue.around, {});
                } catch (const InputError& error) {
                    node.refuse(error.what());
                }
                return;
            }
            std::vector<Vec3> fibres;
            read(node, fibres);
            if (fibres.empty() || fibres.size() > families)
                node.refuse("must be " + std::string(families == 1 ? "one direction" : "one or two directions")
                    + ", or {\"around\": {\"point_mm\", \"axis\"}, \"angle_deg\"}");
            for (const Vec3& fibre : fibres)
                if (!(fibre.norm() > 0.0))
                    node.refuse("a direction must not be zero");
            tissue.fibres = { fibres.front().normalized(), fibres.back().normalized() };
        }

        const Node& node_;
    };

    class FieldWriter {
    public:
        explicit FieldWriter(Json& json)
            : json_(json)
        {
        }

        bool chosen(std::string_view, bool stored) const { return stored; }
        void required(std::string_view key, const auto& value, const auto&... rest)
        {
            json_[std::string(key)] = written(value);
            if constexpr (sizeof...(rest) > 0)
                required(rest...);
        }
        void optional(std::string_view key, const auto& value, bool differs)
        {
            if (differs)
                required(key, value);
        }
        template <class T> void optional(std::string_view key, const std::optional<T>& value)
        {
            if (value)
                required(key, *value);
        }
        void integer(std::string_view key, const auto& value, int, int) { required(key, value); }
        void section(std::string_view key, const auto& body) { json_[std::string(key)] = written_section(body); }

        template <class T> static Json written(const T& value)
        {
            if constexpr (std::is_enum_v<T>)
                return std::string(to_string(value));
            else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>)
                return value;
            else
                return written_section([&](auto& io) { Fields::of(io, value); });
        }
        template <class T> static Json written(const std::vector<T>& items)
        {
            Json list = Json::array();
            for (const T& item : items)
                list.push_back(written(item));
            return list;
        }
        static Json written(const fs::path& path) { return path.generic_string(); }
        /// As the file has it: true, false or "auto".
        static Json written(const ContactMode& contact)
        {
            if (contact == ContactMode::automatic)
                return std::string(to_string(contact));
            return contact == ContactMode::always;
        }
        static Json written(const Vec3& v) { return Json::array({ v.x(), v.y(), v.z() }); }

        static Json written(const fem::PreStrain& tension)
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

        static Json written(const fem::TissueLaw& tissue)
        {
            return std::visit(
                [&]<class Law>(const Law& law) -> Json {
                    if constexpr (kModel<Law>.name.empty()) {
                        throw InputError("a neo-Hookean material is one without a law", "/materials");
                    } else {
                        Json json { { "model", std::string(kModel<Law>.name) } };
                        FieldWriter writer(json);
                        Fields::of(writer, law);
                        if (kModel<Law>.families > 0)
                            json["fibres"] = written_fibres(tissue, kModel<Law>.families);
                        return json;
                    }
                },
                tissue.law);
        }

    private:
        static Json written_section(const auto& body)
        {
            Json json = Json::object();
            FieldWriter writer(json);
            body(writer);
            return json;
        }
        static Json written_fibres(const fem::TissueLaw& tissue, std::size_t families)
        {
            if (tissue.around)
                return written(*tissue.around);
            std::vector<Vec3> directions { tissue.fibres.first };
            if (families > 1)
                directions.push_back(tissue.fibres.second);
            return written(directions);
        }

        Json& json_;
    };

    // ---- the whole case --------------------------------------------------------------------------------------------

    constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kUnits { { { "length", "mm" },
        { "force", "N" }, { "stress", "MPa" }, { "mass", "tonne" }, { "angle", "deg" } } };

    void check_head(const Node& root)
    {
        // The schema is checked first, because another schema may have other keys.
        if (const int schema = root["schema"].integer(0, 1000000); schema != kCaseSchema)
            root["schema"].refuse("the case has schema " + std::to_string(schema) + ", written by "
                + (schema < kCaseSchema ? "an older" : "a newer") + " program; this program reads schema "
                + std::to_string(kCaseSchema));
        root["frame"].must_be("LPS");
        const Node units = root["units"];
        units.object({ "length", "force", "stress", "mass", "angle" });
        for (const auto& [quantity, unit] : kUnits)
            units[quantity].must_be(unit);
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
    const Node root(json, "");
    check_head(root);
    Case read;
    read.folder = folder;
    FieldReader::read_section(root, { "schema", "frame", "units" }, [&](auto& io) { Fields::of(io, read); });
    check_case(read);
    check_plausible(read);
    return read;
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

std::string ablation_to_json(const AblationSpec& ablation) { return FieldWriter::written(ablation).dump(); }

std::string case_to_json(const Case& planned_case)
{
    check_case(planned_case);
    check_plausible(planned_case);
    Json json;
    json["schema"] = kCaseSchema;
    json["frame"] = "LPS";
    for (const auto& [quantity, unit] : kUnits)
        json["units"][std::string(quantity)] = std::string(unit);
    FieldWriter writer(json);
    Fields::of(writer, planned_case);
    try {
        return json.dump(1, '\t') + "\n";
    } catch (const Json::exception& error) {
        throw InputError(std::string("a text is not valid UTF-8: ") + error.what());
    }
}

void write_case(const Case& planned_case) { write_file_atomically(planned_case.file(), case_to_json(planned_case)); }

} // namespace retractor::planner
