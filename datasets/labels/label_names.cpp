// Recognises the names of structures as other tools spell them. A name is divided into words. Side and number are set
// aside, and the other words are looked up in any order ("vena cava superior" is "superior_vena_cava").

#include "datasets/labels/label_presets.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <set>

namespace retractor::datasets {

namespace {

    using Words = std::vector<std::string>;

    bool is_digit(char c) { return c >= '0' && c <= '9'; }
    bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
    bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
    /// Bytes beyond ASCII belong to words, because names may be in any language.
    bool is_word(char c) { return is_digit(c) || is_lower(c) || is_upper(c) || static_cast<unsigned char>(c) >= 0x80; }
    bool all_digits(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), is_digit); }

    /// Divides a name into words. "LeftLung", "left lung" and "Left_Lung" have two words each, "rib5" has two, "T5" has
    /// one.
    Words words_of(std::string_view name)
    {
        Words words;
        bool inside = false;
        for (std::size_t c = 0; c < name.size(); ++c) {
            if (!is_word(name[c])) {
                inside = false;
                continue;
            }
            const bool camel = inside && is_upper(name[c]) && is_lower(name[c - 1]);
            const bool number = inside && is_digit(name[c]) && !is_digit(name[c - 1]) && words.back().size() > 1;
            const bool after_number = inside && !is_digit(name[c]) && all_digits(words.back());
            if (!inside || camel || number || after_number)
                words.emplace_back();
            inside = true;
            words.back() += is_upper(name[c]) ? static_cast<char>(name[c] - 'A' + 'a') : name[c];
        }
        return words;
    }

    std::string joined(const Words& words, char between)
    {
        std::string text;
        for (const std::string& word : words)
            text += (text.empty() ? "" : std::string(1, between)) + word;
        return text;
    }

    /// The common spelling of a plural, Latin or American word.
    std::string common_word(const std::string& word)
    {
        static const std::map<std::string, std::string> kCommon { { "l", "left" }, { "lt", "left" },
            { "sinister", "left" }, { "sinistra", "left" }, { "r", "right" }, { "rt", "right" }, { "dexter", "right" },
            { "dextra", "right" }, { "lungs", "lung" }, { "ribs", "rib" }, { "costa", "rib" }, { "costae", "rib" },
            { "vertebrae", "vertebra" }, { "vertebral", "vertebra" }, { "scapulae", "scapula" },
            { "scapulas", "scapula" }, { "clavicula", "clavicle" }, { "claviculae", "clavicle" },
            { "clavicles", "clavicle" }, { "esophagus", "oesophagus" }, { "humeri", "humerus" },
            { "arteries", "artery" }, { "arteria", "artery" }, { "veins", "vein" }, { "vena", "vein" },
            { "venae", "vein" }, { "vessels", "vessel" }, { "muscles", "muscle" }, { "musculus", "muscle" },
            { "bones", "bone" }, { "cartilages", "cartilage" }, { "kidneys", "kidney" }, { "bronchi", "bronchus" },
            { "bronchia", "bronchus" }, { "lobes", "lobe" }, { "discs", "disc" }, { "disks", "disc" },
            { "disk", "disc" }, { "tumor", "tumour" }, { "tumors", "tumour" }, { "tumours", "tumour" },
            { "lesions", "lesion" }, { "nodules", "nodule" }, { "aneurysms", "aneurysm" }, { "aneurysma", "aneurysm" },
            { "metastases", "metastasis" }, { "lumina", "lumen" }, { "targets", "target" }, { "breasts", "breast" },
            { "intercostals", "intercostal" }, { "trunc", "trunk" }, { "coronaries", "coronary" } };
        const auto found = kCommon.find(word);
        return found == kCommon.end() ? word : found->second;
    }

    std::optional<int> number_of(const std::string& word)
    {
        static const std::array<std::string_view, 12> kOrdinals { "first", "second", "third", "fourth", "fifth",
            "sixth", "seventh", "eighth", "ninth", "tenth", "eleventh", "twelfth" };
        const auto ordinal = std::find(kOrdinals.begin(), kOrdinals.end(), word);
        if (ordinal != kOrdinals.end())
            return static_cast<int>(ordinal - kOrdinals.begin()) + 1;
        int number = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        return error == std::errc {} && end == word.data() + word.size() ? std::optional(number) : std::nullopt;
    }

    bool has(const Words& words, std::string_view word)
    {
        return std::find(words.begin(), words.end(), word) != words.end();
    }

    bool has_any(const Words& words, const std::set<std::string_view>& of)
    {
        return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return of.contains(word); });
    }

    /// The parts of a name.
    struct Parsed {
        Words own; ///< the words of the name in lower case
        Words words; ///< the words in common spelling, without side and fillers
        std::string side; ///< "left", "right" or empty
    };

    Parsed parse(std::string_view name)
    {
        static const std::set<std::string_view> kFillers { "mask", "seg", "segmentation", "label", "structure",
            "entire", "whole", "of", "the" };
        Parsed parsed { words_of(name), {}, {} };
        bool both_sides = false;
        for (const std::string& own : parsed.own) {
            const std::string word = common_word(own);
            if (word == "left" || word == "right") {
                both_sides = both_sides || (!parsed.side.empty() && parsed.side != word);
                parsed.side = word;
            } else if (!kFillers.contains(word))
                parsed.words.push_back(word);
        }
        if (both_sides)
            parsed.side.clear();
        return parsed;
    }

    struct Structure {
        std::string name; ///< the planner's name, without side
        std::string material;
        mesh::Role role = mesh::Role::voxel;
    };

    using Dictionary = std::map<std::string, Structure>;

    std::string key_of(Words words)
    {
        std::sort(words.begin(), words.end());
        return joined(words, ' ');
    }

    /// Adds structures to the dictionary. A structure is a list of names separated by commas: first the planner's name,
    /// then other spellings.
    void add_structures(Dictionary& dictionary, const char* material, mesh::Role role,
        std::initializer_list<std::string_view> structures)
    {
        for (std::string_view rest : structures) {
            const std::string name(rest.substr(0, rest.find(',')));
            while (!rest.empty()) {
                const std::string_view spelling = rest.substr(0, rest.find(','));
                rest.remove_prefix(std::min(rest.size(), spelling.size() + 1));
                dictionary.emplace(key_of(parse(spelling).words), Structure { name, material, role });
            }
        }
    }

    const Dictionary& dictionary()
    {
        static const Dictionary kDictionary = [] {
            Dictionary d;
            add_structures(d, "skin", mesh::Role::wall, { "skin" });
            add_structures(d, "fat", mesh::Role::wall,
                { "fat,subcutaneous fat,subcutaneous adipose tissue,adipose tissue,subcutaneous fatty "
                  "tissue,subcutaneous tissue",
                    "intermuscular_fat", "breast" });
            add_structures(d, "intercostal", mesh::Role::wall, { "intercostal,intercostal muscle" });
            add_structures(d, "muscle", mesh::Role::wall,
                { "muscle,skeletal muscle,muscle tissue", "autochthon,deep muscle of back", "gluteus_maximus",
                    "gluteus_medius", "gluteus_minimus", "iliopsoas", "pectoralis", "pectoralis_major",
                    "pectoralis_minor", "serratus_anterior", "latissimus_dorsi", "trapezius", "rhomboid", "deltoid",
                    "supraspinatus", "infraspinatus", "subscapularis", "teres_major", "teres_minor", "coracobrachial",
                    "triceps_brachii", "biceps_brachii", "sternocleidomastoid", "rectus_abdominis", "erector_spinae",
                    "levator_scapulae", "paravertebral", "chest_wall,thoracic wall" });
            add_structures(d, "bone", mesh::Role::wall,
                { "sternum,breastbone", "manubrium,manubrium sterni", "xiphoid_process,xiphoid", "ribs,rib cage",
                    "spine,vertebrae,vertebral column,spinal column", "vertebrae_body",
                    "vertebrae_cervical,cervical spine,vertebra cervical spine",
                    "vertebrae_thoracic,thoracic spine,vertebra thoracic spine",
                    "vertebrae_lumbar,lumbar spine,vertebra lumbar spine", "scapula,shoulder blade",
                    "clavicle,collar bone,collarbone", "humerus", "sacrum", "hip", "femur", "skull", "skeleton", "bone",
                    "bone_other" });
            add_structures(d, "cartilage", mesh::Role::wall,
                { "costal_cartilages,rib cartilage", "intervertebral_discs,intervertebral disc" });

            add_structures(d, "heart", mesh::Role::at_risk,
                { "heart", "heart_myocardium,myocardium", "heart_atrium,atrium", "heart_ventricle,ventricle",
                    "atrial_appendage,auricle" });
            add_structures(d, "vessel", mesh::Role::at_risk,
                { "aorta", "ascending_aorta", "descending_aorta", "transversal_aorta", "aortic_arch,arch of the aorta",
                    "pulmonary_artery", "pulmonary_trunk", "pulmonary_vein", "pulmonary_vessels",
                    "brachiocephalic_trunk,brachiocephalic artery,innominate artery", "subclavian_artery,subclavian",
                    "common_carotid_artery,carotid artery", "brachiocephalic_vein,innominate vein",
                    "superior_vena_cava", "inferior_vena_cava", "vena_cava,caval vein", "portal_vein_and_splenic_vein",
                    "iliac_artery,common iliac artery", "iliac_vena,iliac vein,common iliac vein",
                    "coronary_arteries,coronary", "celiac_trunk,coeliac trunk" });
            add_structures(d, "soft_tissue", mesh::Role::at_risk, { "spinal_cord" });

            add_structures(d, "lung", mesh::Role::voxel,
                { "lung", "lung_upper_lobe,upper lobe,superior lobe,superior lobe of lung",
                    "lung_middle_lobe,middle lobe", "lung_lower_lobe,lower lobe,inferior lobe,inferior lobe of lung",
                    "lung_upper_third,upper third", "lung_middle_third,middle third", "lung_lower_third,lower third",
                    "cavity" });
            add_structures(d, "vessel", mesh::Role::voxel, { "lung_vessels,blood vessel of lung" });
            add_structures(d, "heart", mesh::Role::voxel, { "pericardium" });
            add_structures(d, "fat", mesh::Role::voxel,
                { "mediastinal_fat", "mediastinum", "torso_fat,fat trunk,visceral fat,visceral adipose tissue" });
            add_structures(d, "cartilage", mesh::Role::voxel,
                { "trachea", "bronchus_main,main bronchus", "lung_trachea_bronchia,trachea and bronchus" });
            add_structures(d, "muscle", mesh::Role::voxel,
                { "oesophagus", "diaphragm", "stomach", "gallbladder,gall bladder", "small_bowel,small intestine",
                    "duodenum", "colon,large bowel,large intestine", "urinary_bladder,bladder" });
            add_structures(d, "liver", mesh::Role::voxel, { "liver", "upper_abdomen" });
            add_structures(d, "soft_tissue", mesh::Role::voxel,
                { "spleen", "kidney", "kidney_cyst", "pancreas", "adrenal_gland,adrenal", "thyroid_gland,thyroid",
                    "prostate", "thymus", "brain", "face", "body", "body_trunc", "body_extremities", "abdomen",
                    "pleural_effusion,effusion pleural cavity", "pericardial_effusion,effusion pericardial cavity",
                    "hilum" });
            return d;
        }();
        return kDictionary;
    }

    const Structure* look_up(const Words& words)
    {
        const auto found = dictionary().find(key_of(words));
        if (found != dictionary().end())
            return &found->second;
        // A general noun adds nothing: "sternum bone", "trapezius muscle", "thyroid gland".
        static const std::set<std::string_view> kNouns { "bone", "muscle", "gland", "organ" };
        Words fewer = words;
        std::erase_if(fewer, [](const std::string& word) { return kNouns.contains(word); });
        const auto again = dictionary().find(key_of(fewer));
        return fewer.size() < words.size() && again != dictionary().end() ? &again->second : nullptr;
    }

    /// Recognises a rib: "rib_left_5", "right rib 5", "Rib L5", "fifth left rib", "5th rib left". A rib without side or
    /// number keeps the part that it has.
    std::optional<Structure> rib_of(const Parsed& parsed)
    {
        if (!has(parsed.words, "rib"))
            return std::nullopt;
        static const std::set<std::string_view> kNothingNew { "rib", "bone", "st", "nd", "rd", "th" };
        std::string side = parsed.side;
        std::optional<int> number;
        for (const std::string& word : parsed.words) {
            const bool with_side = word.size() > 1 && (word[0] == 'l' || word[0] == 'r') && is_digit(word[1]);
            const std::optional<int> here = number_of(with_side ? word.substr(1) : word);
            if (here && !number) {
                number = here;
                if (with_side)
                    side = word[0] == 'l' ? "left" : "right";
            } else if (!kNothingNew.contains(word))
                return std::nullopt;
        }
        const std::string name = (number ? "rib" : "ribs") + (side.empty() ? "" : "_" + side)
            + (number ? "_" + std::to_string(*number) : "");
        return Structure { name, "bone", mesh::Role::wall };
    }

    /// Recognises a vertebra: "vertebrae_T5", "T5 vertebra", "T5", "fifth thoracic vertebra".
    std::optional<Structure> vertebra_of(const Parsed& parsed)
    {
        static const std::map<std::string_view, char> kRegions { { "cervical", 'C' }, { "thoracic", 'T' },
            { "lumbar", 'L' }, { "sacral", 'S' } };
        char region = 0;
        std::optional<int> number;
        for (const std::string& word : parsed.words) {
            const bool level = word.size() > 1 && std::string_view("ctls").find(word[0]) != std::string_view::npos
                && all_digits(std::string_view(word).substr(1));
            const auto named = kRegions.find(word);
            if (level) {
                region = static_cast<char>(word[0] - 'a' + 'A');
                number = number_of(word.substr(1));
            } else if (named != kRegions.end() && region == 0)
                region = named->second;
            else if (number_of(word) && !number)
                number = number_of(word);
            else if (word != "vertebra" && word != "th" && word != "st" && word != "nd" && word != "rd"
                && named == kRegions.end())
                return std::nullopt;
        }
        // The name "S1" alone may also be a first segment, and "fifth thoracic" may be any structure.
        const bool alone = parsed.words.size() == 1 && region != 'S';
        const std::map<char, int> last { { 'C', 7 }, { 'T', 13 }, { 'L', 6 }, { 'S', 5 } };
        if (region == 0 || !number || *number < 1 || *number > last.at(region)
            || !(alone || has(parsed.words, "vertebra")))
            return std::nullopt;
        return Structure { std::string("vertebrae_") + region + std::to_string(*number), "bone", mesh::Role::wall };
    }

    /// Chooses the tissue by single words when the dictionary does not have the structure.
    Structure by_words(const Words& words, std::string name)
    {
        static const std::set<std::string_view> kTarget { "target", "aneurysm", "lumen", "tumour", "lesion", "nodule",
            "mass", "metastasis", "dissection", "thrombus", "cancer", "carcinoma", "neoplasm" };
        static const std::set<std::string_view> kVessel { "aorta", "aortic", "artery", "vein", "vessel", "coronary",
            "aneurysm", "lumen", "dissection", "thrombus", "sinotubular", "cava" };
        static const std::set<std::string_view> kBone { "bone", "rib", "vertebra", "sternum", "scapula", "clavicle",
            "spine" };
        const bool target = has_any(words, kTarget);
        const auto with = [&](const char* material, mesh::Role role) {
            return Structure { std::move(name), material, target ? mesh::Role::target : role };
        };
        if (has_any(words, kVessel))
            return with("vessel", mesh::Role::at_risk);
        if (has(words, "lung"))
            return with("lung", mesh::Role::voxel);
        if (has(words, "liver"))
            return with("liver", mesh::Role::voxel);
        if (has_any(words, { "heart", "cardiac", "myocardium" }))
            return with("heart", mesh::Role::at_risk);
        if (has(words, "cartilage"))
            return with("cartilage", mesh::Role::voxel);
        if (has_any(words, kBone))
            return with("bone", mesh::Role::wall);
        if (has(words, "muscle"))
            return with("muscle", mesh::Role::wall);
        if (has(words, "fat"))
            return with("fat", mesh::Role::voxel);
        return with("soft_tissue", mesh::Role::voxel);
    }

    bool is_target(const Words& words) { return by_words(words, {}).role == mesh::Role::target; }

    Structure structure_of(const Parsed& parsed)
    {
        if (!is_target(parsed.words)) {
            if (auto rib = rib_of(parsed))
                return *rib;
            if (auto vertebra = vertebra_of(parsed))
                return *vertebra;
            if (const Structure* known = look_up(parsed.words)) {
                Structure structure = *known;
                if (!parsed.side.empty())
                    structure.name += "_" + parsed.side;
                else if (structure.name == "lung")
                    structure.name = "lungs";
                return structure;
            }
        }
        return by_words(parsed.words, joined(parsed.own, '_'));
    }

    /// The meaning in "SCHEME^code^meaning".
    std::string_view meaning(std::string_view triple)
    {
        const std::size_t last = triple.rfind('^');
        return last == std::string_view::npos ? std::string_view {} : triple.substr(last + 1);
    }

} // namespace

mesh::LabelInfo describe_structure(std::string_view name, Label id)
{
    const Parsed parsed = parse(name);
    if (parsed.own.empty())
        return { id, "label_" + std::to_string(id), "soft_tissue", mesh::Role::voxel };
    Structure structure = structure_of(parsed);
    return { id, std::move(structure.name), std::move(structure.material), structure.role };
}

std::string structure_from_terminology(std::string_view tags)
{
    constexpr std::string_view kKey = "TerminologyEntry:";
    const std::size_t key = tags.find(kKey);
    std::string_view entry = key == std::string_view::npos ? tags : tags.substr(key + kKey.size());
    entry = entry.substr(0, entry.find('|'));
    // The fields are: context ~ category ~ type ~ modifier of the type ~ context of the region ~ region ~ modifier of
    // the region.
    std::vector<std::string_view> fields;
    while (true) {
        const std::size_t end = entry.find('~');
        fields.push_back(entry.substr(0, end));
        if (end == std::string_view::npos)
            break;
        entry.remove_prefix(end + 1);
    }
    if (fields.size() < 3)
        return {};
    std::string text(meaning(fields[2]));
    if (text.empty() || text == "Tissue")
        return {};
    // The side may belong to the structure or to the region. The region distinguishes the fat of the trunk from the fat
    // under the skin.
    for (const std::size_t field : { 3U, 5U, 6U })
        if (field < fields.size() && !meaning(fields[field]).empty())
            text += " " + std::string(meaning(fields[field]));
    return text;
}

} // namespace retractor::datasets
