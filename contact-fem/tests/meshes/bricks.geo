// Two bricks on top of each other: base is 1 x 2 x 1, block is 1 x 2 x 0.5.
SetFactory("Built-in");
h = 1;
Point(1) = {0, 0, 0, h}; Point(2) = {1, 0, 0, h}; Point(3) = {1, 2, 0, h}; Point(4) = {0, 2, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
lower[] = Extrude {0, 0, 1} { Surface{1}; };
upper[] = Extrude {0, 0, 0.5} { Surface{lower[0]}; };
Physical Volume("base", 7) = {lower[1]};
Physical Volume("block", 9) = {upper[1]};
Physical Surface("bottom") = {1};
Physical Surface("interface") = {lower[0]};
Physical Surface("top") = {upper[0]};
Physical Surface("front") = {lower[2], upper[2]};
Physical Curve("edge") = {1};
