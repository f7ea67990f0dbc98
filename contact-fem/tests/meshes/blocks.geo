// Two rectangles on top of each other in the plane z = 0.25: lower is 2 x 1, upper is 2 x 0.5.
SetFactory("Built-in");
h = 0.7;
Point(1) = {0, 0, 0.25, h};   Point(2) = {2, 0, 0.25, h};
Point(3) = {2, 1, 0.25, h};   Point(4) = {0, 1, 0.25, h};
Point(5) = {2, 1.5, 0.25, h}; Point(6) = {0, 1.5, 0.25, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {3, 5}; Line(6) = {5, 6}; Line(7) = {6, 4};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {3, -7, -6, -5}; // clockwise: its triangles come with negative area
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Physical Surface("lower", 1) = {1};
Physical Surface("upper part", 2) = {2};
Physical Curve("bottom") = {1};
Physical Curve("support") = {1, 4}; // the bottom is in two groups
Physical Curve("top") = {-6};       // against the direction of its line
Physical Curve("interface") = {3};  // bounds both bodies
Physical Curve(42) = {2, 5};        // no name; a part for each body
Physical Point("corner") = {1};
