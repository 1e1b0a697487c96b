#include "planner/evidence/record_generator.h"

#include "mesh/base/assert.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/evidence/hospital_records.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace retractor::planner {

namespace {

    namespace fs = std::filesystem;

    /// The files of hospital records as they grow.
    struct RecordFiles {
        std::string examinations = "examination,patient,date,contrast,inpatient\n";
        std::string administrations = "patient,date,drug,route,examination,ordered\n";
        std::string oxygen = "patient,date\n", surgery = "patient,date\n";
        std::string truth = "examination,complication\n";
        std::size_t made = 0;

        /// @return id of the examination
        std::string examine(const std::string& patient, int day, bool contrast, bool inpatient)
        {
            const std::string id = formatted("E%07zu", ++made);
            examinations
                += id + "," + patient + "," + date_of(day) + (contrast ? ",1" : ",0") + (inpatient ? ",1\n" : ",0\n");
            return id;
        }
        void give(const std::string& patient, int day, const char* drug, const char* route,
            const std::string& examination, const char* ordered)
        {
            administrations
                += patient + "," + date_of(day) + "," + drug + "," + route + "," + examination + "," + ordered + "\n";
        }
        void use_oxygen(const std::string& patient, int day) { oxygen += patient + "," + date_of(day) + "\n"; }
        void operate(const std::string& patient, int day) { surgery += patient + "," + date_of(day) + "\n"; }
    };

    /// A patient who misses one condition of the rule.
    void add_near_miss(RecordFiles& files, const std::string& patient, int day, std::size_t kind)
    {
        constexpr std::size_t kKinds = 6;
        const bool contrast = kind % kKinds != 5;
        const std::string id = files.examine(patient, day, contrast, kind % 2 == 0);
        const char* drug = kind % 3 == 0 ? "antihistamine" : "steroid";
        files.give(patient, day, drug, kind % kKinds == 4 ? "oral" : "iv", kind % kKinds == 4 ? "" : id, "");
        if (kind % kKinds != 0)
            files.use_oxygen(patient, day);
        if (kind % kKinds == 1)
            files.operate(patient, day);
        if (kind % kKinds == 2)
            files.give(patient, day - 2, "steroid", "oral", "", "");
        if (kind % kKinds == 3)
            files.give(patient, day + 3, "antihistamine", "iv", "", "");
        files.truth += id + ",0\n";
    }

    /// One of the five whom the accounting data show.
    void add_found(RecordFiles& files, const std::string& patient, int day, std::size_t n)
    {
        const bool ordered = n == 3, prophylaxis = n == 4;
        const std::string id = files.examine(patient, day, true, ordered || n == 1);
        files.give(patient, day, prophylaxis || n == 2 ? "steroid" : "antihistamine", "iv", id,
            ordered      ? "yes"
                : n == 1 ? "no"
                         : "");
        files.use_oxygen(patient, day);
        files.truth += id + (n < 3 ? ",1\n" : ",0\n");
    }

} // namespace

void write_complication_records(const fs::path& folder, std::size_t examinations, unsigned seed)
{
    constexpr std::size_t kFound = 5;
    if (examinations < kFound)
        throw InputError("the five patients of the study need five examinations", "examinations", { "examinations" });
    const int first = day_of("2003-04-01").value(), last = day_of("2004-03-31").value();
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> any_day(first, last);
    RecordFiles files;
    std::size_t with_contrast = 0;
    for (std::size_t n = 0; with_contrast < examinations; ++n) {
        const std::string patient = formatted("P%07zu", n);
        const int day = any_day(random);
        if (n < kFound) {
            add_found(files, patient, day, n);
            ++with_contrast;
        } else if (n % 10 == 0) {
            add_near_miss(files, patient, day, n / 10);
            with_contrast += n / 10 % 6 != 5 ? 1 : 0;
        } else {
            const bool contrast = n % 11 != 0;
            const std::string id = files.examine(patient, day, contrast, n % 3 == 0);
            if (n % 7 == 0)
                files.give(patient, day + (n % 2 == 0 ? 0 : 5), "other", "iv", "", n % 3 == 0 ? "yes" : "");
            if (n % 13 == 0)
                files.use_oxygen(patient, day);
            if (n % 17 == 0)
                files.operate(patient, day);
            files.truth += id + ",0\n";
            with_contrast += contrast ? 1 : 0;
        }
    }
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw IoError("the folder cannot be made: " + error.message(), folder.string());
    write_file_atomically(folder / "examinations.csv", files.examinations);
    write_file_atomically(folder / "administrations.csv", files.administrations);
    write_file_atomically(folder / "oxygen.csv", files.oxygen);
    write_file_atomically(folder / "surgery.csv", files.surgery);
    write_file_atomically(folder / "truth.csv", files.truth);
}

namespace {

    constexpr std::size_t kPersons = 381, kRecords = 795, kFindings = 241, kThird = kPersons / 3;

    /// A finding of the published rules: its holders, and how many of each group of exposures hold it. Groups in the
    /// order of kGroups; -1: as many as chance gives, rounded down, so that no rule comes of it.
    struct PublishedFinding {
        const char* name;
        int holders;
        std::array<int, 8> in_group;
    };
    // Groups HHH, HHL, LHL, LLH, LLL and, too small for a rule, HLL, LHH, HLH.
    constexpr std::array<int, 8> kGroupSizes { 33, 9, 22, 8, 21, 4, 4, 4 };
    constexpr std::array<const char*, 8> kGroups { "HHH", "HHL", "LHL", "LLH", "LLL", "HLL", "LHH", "HLH" };
    constexpr std::array kPublished {
        PublishedFinding { "past history of pigmentation", 172, { 21, 9, -1, -1, -1, -1, -1, -1 } },
        PublishedFinding { "past history of acneiform eruptions", 231, { 25, 9, -1, -1, -1, -1, -1, -1 } },
        PublishedFinding { "arthralgia", 243, { -1, 7, 18, -1, -1, -1, -1, -1 } },
        PublishedFinding { "abdominal pain", 118, { -1, -1, 11, 5, -1, -1, -1, -1 } },
        PublishedFinding { "constipation", 147, { -1, -1, 11, -1, -1, -1, -1, -1 } },
        PublishedFinding { "cough", 157, { -1, -1, 11, -1, -1, -1, -1, -1 } },
        PublishedFinding { "general fatigue", 248, { -1, -1, -1, 8, -1, -1, -1, -1 } },
        PublishedFinding { "headache", 218, { -1, -1, -1, 6, -1, -1, -1, -1 } },
        PublishedFinding { "diarrhea", 124, { -1, -1, -1, -1, 12, -1, -1, -1 } },
    };

    using Exposures = std::array<char, 3>; ///< H, M or L of A, B and C

    /// The persons of the groups first, then those with at least one middle exposure. A third of all persons is high, a
    /// third low, in each exposure.
    std::vector<Exposures> exposures_of_persons()
    {
        std::vector<Exposures> persons;
        for (std::size_t g = 0; g < kGroups.size(); ++g)
            for (int n = 0; n < kGroupSizes[g]; ++n)
                persons.push_back({ kGroups[g][0], kGroups[g][1], kGroups[g][2] });
        const std::size_t grouped = persons.size();
        persons.resize(kPersons, { 'M', 'M', 'M' });
        // Middle: the first third of the others in A, the second in B, the rest in C, and C again from the front.
        const std::size_t others = kPersons - grouped;
        const auto is_middle = [&](std::size_t exposure, std::size_t other) {
            if (exposure < 2)
                return other >= exposure * kThird && other < (exposure + 1) * kThird;
            const std::size_t rest = others - 2 * kThird;
            return other >= 2 * kThird || other < kThird - rest;
        };
        for (std::size_t e = 0; e < 3; ++e) {
            auto high = kThird
                - static_cast<std::size_t>(std::count_if(persons.begin(), persons.begin() + static_cast<long>(grouped),
                    [e](const Exposures& one) { return one[e] == 'H'; }));
            for (std::size_t other = 0; other < others; ++other) {
                if (is_middle(e, other))
                    continue;
                persons[grouped + other][e] = high > 0 ? 'H' : 'L';
                high -= high > 0 ? 1 : 0;
            }
        }
        return persons;
    }

    /// Marks the holders of a finding.
    std::vector<bool> holders_of(const PublishedFinding& finding, std::mt19937& random)
    {
        std::vector<bool> holders(kPersons, false);
        std::size_t from = 0, left = static_cast<std::size_t>(finding.holders);
        for (std::size_t g = 0; g < kGroupSizes.size(); ++g) {
            const auto size = static_cast<std::size_t>(kGroupSizes[g]);
            const std::size_t count = finding.in_group[g] >= 0
                ? static_cast<std::size_t>(finding.in_group[g])
                : size * static_cast<std::size_t>(finding.holders) / kPersons;
            for (std::size_t n = 0; n < count; ++n)
                holders[from + n] = true;
            from += size;
            left -= count;
        }
        std::vector<std::size_t> others(kPersons - from);
        std::iota(others.begin(), others.end(), from);
        std::ranges::shuffle(others, random);
        RETRACTOR_ASSERT(left <= others.size());
        for (std::size_t n = 0; n < left; ++n)
            holders[others[n]] = true;
        return holders;
    }

    double concentration(char level, std::mt19937& random)
    {
        const double low = level == 'L' ? 0.1 : level == 'M' ? 1.1 : 2.1;
        return std::round(1e6 * std::uniform_real_distribution<double>(low, low + 0.8)(random)) / 1e6;
    }

} // namespace

void write_exposure_records(const fs::path& file, unsigned seed)
{
    std::mt19937 random(seed);
    std::vector<PublishedFinding> findings(kPublished.begin(), kPublished.end());
    std::vector<std::string> names;
    for (const PublishedFinding& finding : findings)
        names.emplace_back(finding.name);
    while (findings.size() < kFindings) { // others: as frequent in every group as among all
        findings.push_back(
            { "", std::uniform_int_distribution<int>(3, 190)(random), { -1, -1, -1, -1, -1, -1, -1, -1 } });
        names.push_back("finding " + std::to_string(findings.size()));
    }
    std::string text = "person,year,A,B,C";
    for (const std::string& name : names)
        text += "," + name;
    text += "\n";
    const std::vector<Exposures> exposures = exposures_of_persons();
    std::vector<std::vector<bool>> holders;
    for (const PublishedFinding& finding : findings)
        holders.push_back(holders_of(finding, random));
    std::vector<std::string> records;
    const auto add = [&](std::size_t person, int year, bool earliest) {
        std::string record = formatted("S%03zu,%d", person, year);
        for (std::size_t e = 0; e < 3; ++e)
            record += formatted(",%.6f",
                earliest ? concentration(exposures[person][e], random)
                         : std::uniform_real_distribution<double>(0.1, 2.9)(random));
        for (const std::vector<bool>& held : holders)
            record += (earliest ? held[person] : random() % 2 == 0) ? ",1" : ",0";
        records.push_back(record + "\n");
    };
    const std::size_t with_three = (kRecords - kPersons) / 2;
    for (std::size_t person = 0; person < kPersons; ++person) {
        const int first = 2001 + (person < with_three ? 0 : static_cast<int>(person % 3));
        add(person, first, true);
        for (int later = 1; person < with_three && later <= 2; ++later)
            add(person, first + later, false);
    }
    std::ranges::shuffle(records, random);
    for (const std::string& record : records)
        text += record;
    write_file_atomically(file, text);
}

void write_random_findings(
    const fs::path& file, std::size_t persons, std::size_t findings, double share, unsigned seed, const Job& job)
{
    write_file_atomically(file, [&](const fs::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out << "person";
        for (std::size_t f = 0; f < findings; ++f)
            out << ",finding " << f + 1;
        out << '\n';
        std::mt19937 random(seed);
        const auto limit = static_cast<std::uint32_t>(share * 4294967295.0);
        std::string record;
        constexpr std::size_t kReportEvery = 1 << 14;
        for (std::size_t person = 0; person < persons; ++person) {
            if (person % kReportEvery == 0)
                job.report("persons", static_cast<double>(person) / static_cast<double>(persons));
            if (job.cancelled())
                throw SolverError("cancelled: the file is not written");
            record = std::to_string(person);
            for (std::size_t f = 0; f < findings; ++f)
                record += random() < limit ? ",1" : ",0";
            out << record << '\n';
        }
        if (!out.flush())
            throw IoError("cannot be written", file.string());
    });
}

} // namespace retractor::planner
