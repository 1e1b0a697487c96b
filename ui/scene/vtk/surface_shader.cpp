#include "ui/scene/vtk/surface_shader.h"

#include <vtkActor.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>

#include <string>

namespace retractor::ui {

namespace {

    // Value noise on an integer hash. The noise is the same on every driver, unlike the usual hash of sines.
    constexpr const char* kNoise = R"(
float retractorHash(ivec3 p)
{
  uint h = uint(p.x) * 374761393u + uint(p.y) * 668265263u + uint(p.z) * 2147483647u;
  h = (h ^ (h >> 13u)) * 1274126177u;
  h = h ^ (h >> 16u);
  return float(h & 65535u) / 65535.0;
}
float retractorNoise(vec3 x)
{
  vec3 fi = floor(x);
  ivec3 i = ivec3(fi);
  vec3 f = x - fi;
  f = f * f * (3.0 - 2.0 * f);
  float a = mix(retractorHash(i), retractorHash(i + ivec3(1, 0, 0)), f.x);
  float b = mix(retractorHash(i + ivec3(0, 1, 0)), retractorHash(i + ivec3(1, 1, 0)), f.x);
  float c = mix(retractorHash(i + ivec3(0, 0, 1)), retractorHash(i + ivec3(1, 0, 1)), f.x);
  float d = mix(retractorHash(i + ivec3(0, 1, 1)), retractorHash(i + ivec3(1, 1, 1)), f.x);
  return mix(mix(a, b, f.y), mix(c, d, f.y), f.z);
}
)";

    struct FinishValues {
        double ambient, diffuse, specular, specular_power;
        /// Procedural variation: coarse and fine cell in mm, colour strength, bump height in mm.
        double coarse_mm, fine_mm, contrast, bump_mm;
    };

    FinishValues values_of(Finish finish)
    {
        switch (finish) {
        case Finish::skin:
            return { 0.16, 0.84, 0.12, 14.0, 9.0, 1.2, 0.06, 0.05 };
        case Finish::wet:
            return { 0.14, 0.84, 0.35, 40.0, 7.0, 1.8, 0.35, 0.35 };
        case Finish::bone:
            return { 0.16, 0.84, 0.14, 18.0, 6.0, 0.9, 0.14, 0.06 };
        case Finish::metal:
            return { 0.10, 0.55, 0.80, 60.0, 1.0, 1.0, 0.0, 0.0 };
        case Finish::unlit:
            return { 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0 };
        case Finish::matte:
            break;
        }
        return { 0.15, 0.85, 0.0, 1.0, 10.0, 2.0, 0.2, 0.0 };
    }

    std::string number(double x) { return "float(" + std::to_string(x) + ")"; }

    void pass_position(vtkShaderProperty& shader)
    {
        shader.AddVertexShaderReplacement(
            "//VTK::PositionVC::Dec", true, "//VTK::PositionVC::Dec\nout vec3 retractorPosition;\n", false);
        shader.AddVertexShaderReplacement(
            "//VTK::PositionVC::Impl", true, "//VTK::PositionVC::Impl\n  retractorPosition = vertexMC.xyz;\n", false);
        shader.AddFragmentShaderReplacement("//VTK::PositionVC::Dec", true,
            std::string("//VTK::PositionVC::Dec\nin vec3 retractorPosition;\n") + kNoise, false);
    }

    /// Adds darker and lighter patches to the colour, and bumps from the noise's screen derivatives to the normal
    /// [Mikkelsen 2010].
    void add_texture(vtkShaderProperty& shader, const FinishValues& v, double strength)
    {
        pass_position(shader);
        shader.AddFragmentShaderReplacement("//VTK::Color::Impl", true,
            "//VTK::Color::Impl\n"
            "  float retractorCoarse = retractorNoise(retractorPosition / "
                + number(v.coarse_mm)
                + ");\n"
                  "  float retractorFine = retractorNoise(retractorPosition / "
                + number(v.fine_mm)
                + " + vec3(17.0));\n"
                  "  float retractorTone = 1.0 + "
                + number(strength * v.contrast)
                + " * (0.6 * retractorCoarse + 0.4 * retractorFine - 0.5) * 2.0;\n"
                  "  vec3 retractorTint = mix(vec3(1.0), vec3(1.03, 0.94, 0.92), retractorCoarse * "
                + number(strength)
                + ");\n"
                  "  ambientColor *= retractorTone * retractorTint;\n"
                  "  diffuseColor *= retractorTone * retractorTint;\n"
                  "  specularColor *= 0.6 + 0.8 * retractorFine;\n",
            false);
        if (v.bump_mm <= 0.0)
            return;
        shader.AddFragmentShaderReplacement("//VTK::Normal::Impl", true,
            "//VTK::Normal::Impl\n"
            "  {\n"
            "    float height = "
                + number(strength * v.bump_mm) + " * retractorNoise(retractorPosition / " + number(v.fine_mm)
                + " + vec3(17.0));\n"
                  "    vec3 sx = dFdx(vertexVC.xyz), sy = dFdy(vertexVC.xyz);\n"
                  "    vec3 r1 = cross(sy, normalVCVSOutput), r2 = cross(normalVCVSOutput, sx);\n"
                  "    float det = dot(sx, r1);\n"
                  "    vec3 slope = sign(det) * (dFdx(height) * r1 + dFdy(height) * r2);\n"
                  "    if (abs(det) > 1e-12) normalVCVSOutput = normalize(abs(det) * normalVCVSOutput - slope);\n"
                  "  }\n",
            false);
    }

    /// Adds the reflection of a studio with two soft boxes: bright above, dark at the horizon, grey below.
    void add_steel(vtkShaderProperty& shader)
    {
        shader.AddFragmentShaderReplacement("//VTK::Light::Impl", true,
            "//VTK::Light::Impl\n"
            "  {\n"
            "    vec3 mirrored = reflect(vec3(0.0, 0.0, -1.0), normalVCVSOutput);\n"
            "    float sky = smoothstep(-0.05, 0.75, mirrored.y);\n"
            "    float floorLight = 0.35 * smoothstep(0.1, -0.9, mirrored.y);\n"
            "    float box = smoothstep(0.80, 0.90, mirrored.z + 0.35 * mirrored.x);\n"
            "    vec3 studio = vec3(0.20, 0.22, 0.25) + vec3(0.62, 0.65, 0.70) * (0.75 * sky + floorLight) + "
            "vec3(0.35) * box;\n"
            "    fragOutput0.rgb = mix(fragOutput0.rgb, studio, 0.65);\n"
            "  }\n",
            false);
    }

    void add_rim(vtkShaderProperty& shader, const Color& color)
    {
        shader.AddFragmentShaderReplacement("//VTK::Light::Impl", true,
            "//VTK::Light::Impl\n"
            "  {\n"
            "    float rim = pow(1.0 - clamp(abs(normalVCVSOutput.z), 0.0, 1.0), 2.0);\n"
            "    vec3 glow = mix(vec3("
                + number(color.r) + ", " + number(color.g) + ", " + number(color.b)
                + "), vec3(1.0), 0.45);\n"
                  "    fragOutput0.rgb = mix(fragOutput0.rgb, glow, 0.75 * rim);\n"
                  "  }\n",
            false);
    }

} // namespace

void apply_look(vtkActor& actor, const Look& look, bool highlighted)
{
    FinishValues v = values_of(look.finish);
    if (highlighted)
        v.ambient = 0.45;
    vtkProperty& property = *actor.GetProperty();
    property.SetColor(look.color.r, look.color.g, look.color.b);
    property.SetAmbient(v.ambient);
    property.SetDiffuse(v.diffuse);
    property.SetSpecular(v.specular);
    property.SetSpecularPower(v.specular_power);
    property.SetSpecularColor(1.0, 1.0, 1.0);
    property.SetLighting(look.finish != Finish::unlit);
    if (look.finish == Finish::unlit)
        return;
    vtkShaderProperty& shader = *actor.GetShaderProperty();
    if (look.finish == Finish::metal)
        add_steel(shader);
    else if (highlighted)
        add_rim(shader, look.color);
    else if (look.texture > 0.0)
        add_texture(shader, v, look.texture);
}

} // namespace retractor::ui
