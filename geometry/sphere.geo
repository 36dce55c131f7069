// Solid sphere centred at the origin. Lengths in metres.
SetFactory("OpenCASCADE");

DefineConstant[
  radius = {0.25, Name "Parameters/radius"},  // [m]
  size   = {0.05, Name "Parameters/size"},    // [m] edge length of the tetrahedra, at the surface
  growth = {0, Name "Parameters/growth"}      // [-] of the edge length, per depth below the surface
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size + growth * radius;

Sphere(1) = {0, 0, 0, radius};

If (growth > 0)
  Field[1] = MathEval;
  Field[1].F = Sprintf("%g + %g * (%g - Sqrt(x*x + y*y + z*z))", size, growth, radius);
  Background Field = 1;
  Mesh.MeshSizeExtendFromBoundary = 0;
EndIf

Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
