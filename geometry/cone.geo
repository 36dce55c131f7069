// Solid penetrometer: a cone under a round shaft, tip at the origin, axis along z. Lengths in metres.
// Parts of its surface: tip, the cone and, under a sleeve, its cylindrical extension; sleeve, if it has a length; shaft, the rest.
SetFactory("OpenCASCADE");

DefineConstant[
  radius = {0.1, Name "Parameters/radius"},  // [m] of the shaft
  angle  = {60,  Name "Parameters/angle"},   // [deg] at the tip, between opposite sides
  shaft  = {1.0, Name "Parameters/shaft"},   // [m] length of the shaft
  sleeve = {0.0, Name "Parameters/sleeve"},  // [m] length of the friction sleeve, a part of the shaft; 0: none
  extension = {0.4 * radius, Name "Parameters/extension"},  // [m] of the shaft between cone and sleeve
  size   = {0.03, Name "Parameters/size"}    // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size / 8;
Mesh.MeshSizeMax = size;

height = radius / Tan(angle * Pi / 360);

// In eight sectors that stay faces of their own, so that at least eight triangles meet at the tip. A single face may have three
// there, of which one spans most of the circumference and cuts through the cone.
Geometry.OCCUnionUnify = 0;
For i In {0:7}
  Cone(10 + i) = {0, 0, 0, 0, 0, height, 0, radius, Pi / 4};
  Rotate {{0, 0, 1}, {0, 0, 0}, i * Pi / 4} { Volume{10 + i}; }
EndFor
If (sleeve > 0)
  Cylinder(2) = {0, 0, height, 0, 0, extension, radius};
  Cylinder(4) = {0, 0, height + extension, 0, 0, sleeve, radius};
  Cylinder(5) = {0, 0, height + extension + sleeve, 0, 0, shaft - extension - sleeve, radius};
  BooleanUnion(3) = { Volume{10:17}; Delete; }{ Volume{2, 4, 5}; Delete; };
Else
  Cylinder(2) = {0, 0, height, 0, 0, shaft, radius};
  BooleanUnion(3) = { Volume{10:17}; Delete; }{ Volume{2}; Delete; };
  extension = 0;
EndIf

outside() = Abs(Boundary{ Volume{3}; });
r = 1.001 * radius;
e = 0.001 * radius;
tip() = Surface In BoundingBox {-r, -r, -e, r, r, height + extension + e};
side() = Surface In BoundingBox {-r, -r, height + extension - e, r, r, height + extension + sleeve + e};
rest() = outside();
rest() -= tip();
rest() -= side();

// From the tip on, edges of a twelfth of the circumference: with longer ones a few facets would cut through the cone.
Field[1] = MathEval;
Field[1].F = Sprintf("%g + %g * z", size / 8, Pi / 6 * radius / height);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;

Physical Volume("body") = {3};
Physical Surface("contact") = outside();
Physical Surface("tip") = tip();
If (sleeve > 0)
  Physical Surface("sleeve") = side();
EndIf
Physical Surface("shaft") = rest();
